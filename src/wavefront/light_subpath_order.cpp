#include "wavefront/light_subpath_order.h"

#include "base/parallel.h"

#include <bit>

namespace metrolux::core {

namespace {

constexpr int kMostBits = 7;  ///< for each axis: 8 MB of counts

/// Cells of a cube around the scene, numbered along the curve.
class MortonCells {
  public:
    MortonCells(const SceneBounds& bounds, int bits)
        : low_(bounds.center - Vec3f(2 * bounds.radius)),
          scale_(static_cast<float>(1 << bits) / (4 * bounds.radius)),
          last_(static_cast<float>((1 << bits) - 1)) {
        for (uint32_t i = 0; i < (1u << bits); ++i)
            for (int b = 0; b < bits; ++b) spread_[i] |= ((i >> b) & 1u) << (3 * b);
    }
    uint32_t operator()(const Vec3f& p) const {
        uint32_t cell = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const float x = (p[axis] - low_[axis]) * scale_;
            // In this form what is not a number is in cell 0.
            cell |= spread_[x > 0 ? static_cast<uint32_t>(std::min(x, last_)) : 0] << axis;
        }
        return cell;
    }

  private:
    Vec3f low_;
    float scale_, last_;
    uint32_t spread_[1 << kMostBits] = {};
};

}  // namespace

std::vector<uint32_t> coherentOrder(const WalkRules& walk, size_t count,
                                    const std::function<IndependentStream(size_t)>& streamOf) {
    const int bits = std::min(static_cast<int>(std::bit_width(count)) / 3, kMostBits);
    const SceneBounds& bounds = walk.scene.bounds();
    const MortonCells cells(bounds, bits);

    std::vector<uint32_t> cellOf(count);
    constexpr size_t kChunk = 1024;
    parallelFor((count + kChunk - 1) / kChunk, [&](size_t chunk) {
        LightStart start;
        for (size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
            IndependentStream stream = streamOf(i);
            if (startLight(walk, stream, start))
                cellOf[i] = cells(start.ray.origin + start.ray.direction * bounds.radius);
        }
    });

    std::vector<uint32_t> next((size_t{1} << (3 * bits)) + 1, 0), order(count);
    for (const uint32_t cell : cellOf) ++next[cell + 1];
    for (size_t cell = 1; cell < next.size(); ++cell) next[cell] += next[cell - 1];
    for (size_t i = 0; i < count; ++i) order[next[cellOf[i]]++] = static_cast<uint32_t>(i);
    return order;
}

}  // namespace metrolux::core
