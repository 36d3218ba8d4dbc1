#pragma once
#include <array>
#include <cstddef>
#include <vector>

namespace metrolux::core {

/// Values of each pixel, one channel. The plane goes on beyond the border by kMargin, with the nearest
/// pixel's values, so that loops over neighbors need no cases.
class PaddedPlane {
  public:
    static constexpr int kMargin = 16;
    PaddedPlane() = default;
    PaddedPlane(int width, int height)
        : width_(width),
          height_(height),
          stride_(static_cast<size_t>(width) + 2 * kMargin),
          values_(stride_ * (static_cast<size_t>(height) + 2 * kMargin)) {}
    int width() const { return width_; }
    int height() const { return height_; }
    /// Also of pixels beyond the border, by up to kMargin. Rows are contiguous.
    float* at(int x, int y) {
        return &values_[static_cast<size_t>(y + kMargin) * stride_ + static_cast<size_t>(x + kMargin)];
    }
    const float* at(int x, int y) const { return const_cast<PaddedPlane*>(this)->at(x, y); }
    /// Sets the values beyond the border.
    void extend();

  private:
    int width_ = 0, height_ = 0;
    size_t stride_ = 0;
    std::vector<float> values_;
};

using ColorPlanes = std::array<PaddedPlane, 3>;

/// Planes for three channels, zero.
ColorPlanes makeColorPlanes(int width, int height);

/// Means over squares of (2 radius + 1)^2 pixels, of fewer at the border.
PaddedPlane boxMeans(const PaddedPlane& plane, int radius);

}  // namespace metrolux::core
