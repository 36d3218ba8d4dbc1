#include "transport/vertex_grid.h"

#include "base/parallel.h"
#include "base/prefetch.h"
#include "base/rng.h"

#include <bit>

namespace metrolux {

namespace {

/// Cells of a block, as many as starts_ fit in a cache line.
constexpr uint32_t kBlockCells = 16;

}  // namespace

uint32_t VertexGrid::bucketOf(int64_t x, int64_t y, int64_t z) const {
    const uint32_t block = static_cast<uint32_t>(hashKey(x >> 2, y >> 1, z >> 1)) & blockMask_;
    return block * kBlockCells + static_cast<uint32_t>((x & 3) | (y & 1) << 2 | (z & 1) << 3);
}

int VertexGrid::bucketsAround(const Vec3f& p, std::array<std::span<const Entry>, 8>& buckets) const {
    int64_t low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = static_cast<int64_t>(std::floor((double(p[axis]) - radius_) * inverseCell_));
        high[axis] = static_cast<int64_t>(std::floor((double(p[axis]) + radius_) * inverseCell_));
    }
    std::array<uint32_t, 8> touched;
    int count = 0;
    for (int64_t z = low[2]; z <= high[2]; ++z)
        for (int64_t y = low[1]; y <= high[1]; ++y)
            for (int64_t x = low[0]; x <= high[0]; ++x) {
                const uint32_t bucket = bucketOf(x, y, z);
                if (std::find(touched.begin(), touched.begin() + count, bucket) != touched.begin() + count)
                    continue;
                touched[count++] = bucket;
                prefetch(&starts_[bucket]);
            }
    int filled = 0;
    for (int i = 0; i < count; ++i) {
        const uint32_t begin = starts_[touched[i]], end = starts_[touched[i] + 1];
        if (begin == end) continue;
        buckets[filled++] = {entries_.data() + begin, end - begin};
        prefetch(entries_.data() + begin);
    }
    return filled;
}

template <class PositionOf>
void VertexGrid::buildFrom(size_t n, float radius, PositionOf&& positionOf) {
    radius_ = radius;
    radiusSquared_ = radius * radius;
    // A hair wider than two radii, so that rounding never makes a ball touch three cells along an axis.
    inverseCell_ = 1.0 / (2.0 * double(radius) * (1.0 + 1e-6));
    entries_.resize(n);
    if (n == 0) return;
    const uint32_t blocks = std::bit_ceil(static_cast<uint32_t>(n / kBlockCells + 1));
    blockMask_ = blocks - 1;
    starts_.assign(size_t(blocks) * kBlockCells + 1, 0);

    std::vector<uint32_t> buckets(n);
    constexpr size_t kChunk = 8192;
    parallelFor((n + kChunk - 1) / kChunk, [&](size_t chunk) {
        for (size_t i = chunk * kChunk; i < std::min(n, (chunk + 1) * kChunk); ++i) {
            const Vec3f& p = positionOf(i);
            const auto cell = [&](float x) {
                return static_cast<int64_t>(std::floor(double(x) * inverseCell_));
            };
            buckets[i] = bucketOf(cell(p.x), cell(p.y), cell(p.z));
        }
    });
    for (const uint32_t b : buckets) ++starts_[b + 1];
    for (size_t b = 1; b < starts_.size(); ++b) starts_[b] += starts_[b - 1];
    std::vector<uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (size_t i = 0; i < n; ++i) entries_[next[buckets[i]]++] = {positionOf(i), static_cast<uint32_t>(i)};
}

void VertexGrid::build(std::span<const Vertex> vertices, float radius) {
    buildFrom(vertices.size(), radius, [&](size_t i) -> const Vec3f& { return vertices[i].si.p; });
}

void VertexGrid::buildPoints(std::span<const Vec3f> points, float radius) {
    buildFrom(points.size(), radius, [&](size_t i) -> const Vec3f& { return points[i]; });
}

void VertexGrid::clear() {
    entries_.clear();
    starts_.clear();
}

}  // namespace metrolux
