#pragma once
#include "base/math.h"
#include "base/state.h"
#include "image/film_window.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace metrolux::core {

/// A class of paths: properties of the path, whoever made it.
struct PathClass {
    uint16_t region = 0;  ///< of the film, EyeFactors::regionOf()
    int smooth = 0;       ///< inner vertices that scatter by a smooth lobe
};

/// What an eye subpath finds by hit and nee, as a path tracer would weigh it: luminance by PathClass::smooth,
/// the last for all more. (The first is seen directly and has no other technique.)
using EyeEstimate = std::array<float, 4>;
/// Adds what is found on a path with so many smooth vertices.
inline void addTo(EyeEstimate& estimate, int smooth, float luminance) {
    estimate[std::min(static_cast<size_t>(smooth), estimate.size() - 1)] += luminance;
}

/// Variance-aware weights. The balance heuristic takes every technique for one whose variance is its second
/// moment, as that of rare light subpaths is. An eye subpath that is shaded by a lamp in full view estimates
/// far better than that: with second moment / variance as a factor of its count it gets the weight that it
/// deserves (Grittmann, Georgiev, Slusallek, Krivanek 2019, Variance-Aware Multiple Importance Sampling,
/// eq. 16; here for hit and nee together, since the estimate that both make has one variance, and by classes
/// of paths: a tile of the film and the number of smooth vertices). The factors come from earlier passes, so
/// that weights depend on the path and the past alone and stay unbiased.
class EyeFactors {
  public:
    explicit EyeFactors(const FilmWindow& window);

    uint16_t regionOf(const Vec2f& raster) const {
        const int x = std::clamp(static_cast<int>(std::floor(raster.x)) - window_.x, 0, window_.width - 1),
                  y = std::clamp(static_cast<int>(std::floor(raster.y)) - window_.y, 0, window_.height - 1);
        return regionAt(x, y);
    }
    /// Of a pixel, an index in the window.
    uint16_t regionOf(uint32_t pixel) const {
        return regionAt(static_cast<int>(pixel) % window_.width, static_cast<int>(pixel) / window_.width);
    }
    size_t regionCount() const { return size_t(columns_) * size_t(rows_); }
    float at(const PathClass& c) const {
        return factors_[c.region * kClasses + std::min(static_cast<size_t>(c.smooth), kClasses - 1)];
    }

    /// What the pass's eye subpath of a pixel has found. One call for each pixel; pixels may be set at once.
    void set(uint32_t pixel, const EyeEstimate& estimate) {
        std::copy(estimate.begin(), estimate.end(), current_.begin() + ptrdiff_t(pixel * kClasses));
    }
    /// Closes a pass: the next has new factors.
    void endPass();
    /// What the eye subpath of a pixel has found in the last pass, and what in the one before; until the next
    /// calls set().
    float lastOf(size_t pixel) const { return sumOf(previous_, pixel, 0); }
    float lastButOneOf(size_t pixel) const { return sumOf(current_, pixel, 0); }
    /// Per region: the most that an eye subpath has found on paths that are not seen directly.
    const std::vector<float>& largest() const { return largest_; }

    uint32_t passes() const { return passes_; }
    /// Mean of the factors over the film, of the paths with so many smooth vertices.
    double mean(int smooth) const;

    /// Between two passes.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(passes_, previous_, second_, variance_, largest_);
        checkState(largest_.size() == regionCount() && previous_.size() == current_.size() &&
                       second_.size() == factors_.size() && variance_.size() == factors_.size(),
                   "estimates of this film's eye subpaths");
        updateFactors();
    }

  private:
    static constexpr size_t kClasses = std::tuple_size_v<EyeEstimate>;
    void updateFactors();
    uint16_t regionAt(int x, int y) const { return static_cast<uint16_t>(y / tile_ * columns_ + x / tile_); }
    static float sumOf(const std::vector<float>& estimates, size_t pixel, size_t first) {
        float sum = 0;
        for (size_t k = first; k < kClasses; ++k) sum += estimates[pixel * kClasses + k];
        return sum;
    }

    FilmWindow window_;
    int tile_, columns_, rows_;
    uint32_t passes_ = 0;
    std::vector<float> current_, previous_;  ///< of each pixel and class
    /// Of each region and class: sums over its pixels and the passes, of squares, and of half the squares of
    /// the differences between a pass and the one before.
    std::vector<double> second_, variance_;
    std::vector<float> factors_;
    std::vector<float> largest_;
};

}  // namespace metrolux::core
