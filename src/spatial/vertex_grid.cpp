#include "spatial/vertex_grid.h"

#include "base/parallel.h"
#include "spatial/cell_blocks.h"

#include <algorithm>
#include <bit>

namespace metrolux::core {

namespace {

using cellblocks::kCells;
/// Parts of the table that are sorted by themselves.
constexpr uint32_t kSections = 64;

}  // namespace

VertexGrid::Cells VertexGrid::cellsOf(const Vec3f& p) const {
    // One or two cells along each axis. Their blocks' hashes share what they have in common, and no two cells
    // have the same place in their blocks, so that all buckets differ, whatever the hashes.
    std::array<std::array<int64_t, 2>, 3> cell;
    std::array<uint32_t, 3> count;
    for (int axis = 0; axis < 3; ++axis) {
        const auto low = static_cast<int64_t>(std::floor((double(p[axis]) - radius_) * inverseCell_));
        const auto high = static_cast<int64_t>(std::floor((double(p[axis]) + radius_) * inverseCell_));
        cell[axis] = {low, high};
        count[axis] = high > low ? 2 : 1;
    }
    std::array<uint64_t, 2> keyX;
    for (uint32_t x = 0; x < 2; ++x) keyX[x] = cellblocks::keyX(cell[0][x]);
    std::array<uint64_t, 4> keyXY;
    for (uint32_t i = 0; i < 4; ++i) keyXY[i] = cellblocks::keyY(keyX[i & 1], cell[1][i >> 1]);

    Cells cells;
    for (uint32_t z = 0; z < count[2]; ++z)
        for (uint32_t y = 0; y < count[1]; ++y)
            for (uint32_t x = 0; x < count[0]; ++x) {
                const uint64_t key = cellblocks::keyZ(keyXY[2 * y + x], cell[2][z]);
                const uint32_t bucket =
                    cellblocks::bucket(key, blockMask_, cell[0][x], cell[1][y], cell[2][z]);
                cells.buckets[cells.count++] = bucket;
            }
    return cells;
}

/// Of the n positions with the indices indexOf(0), indexOf(1) ...
template <class IndexOf>
void VertexGrid::sort(const PointSpan& positions, size_t n, IndexOf&& indexOf, float radius) {
    radius_ = radius;
    radiusSquared_ = radius * radius;
    // A hair wider than two radii, so that rounding never makes a ball touch three cells along an axis.
    inverseCell_ = 1.0 / (2.0 * double(radius) * (1.0 + 1e-6));
    entries_.resize(n);
    if (n == 0) return;
    const uint32_t blocks = std::bit_ceil(static_cast<uint32_t>(n / kCells + 1));
    blockMask_ = blocks - 1;
    starts_.resize(size_t(blocks) * kCells + 1);

    const auto bucketOf = [&](const Vec3f& p) {
        const auto cell = [&](float x) { return static_cast<int64_t>(std::floor(double(x) * inverseCell_)); };
        return cellblocks::bucket(blockMask_, cell(p.x), cell(p.y), cell(p.z));
    };
    // Two stable counting sorts: by section, a range of buckets, then each section by bucket. Both run in
    // parallel, and a section's counters and entries fit the cache.
    const uint32_t sections = std::min(blocks, kSections);
    const uint32_t sectionBuckets = blocks / sections * kCells;
    const auto sectionOf = [shift = std::countr_zero(sectionBuckets)](uint32_t b) { return b >> shift; };
    constexpr size_t kChunk = 8192;
    const size_t chunks = (n + kChunk - 1) / kChunk;
    std::vector<std::array<uint32_t, kSections>> places(chunks);
    UninitializedVector<uint32_t> buckets(n), bySection(n);  // bySection: indices
    parallelFor(chunks, [&](size_t chunk) {
        places[chunk].fill(0);
        for (size_t i = chunk * kChunk; i < std::min(n, (chunk + 1) * kChunk); ++i) {
            buckets[i] = bucketOf(positions[indexOf(i)]);
            ++places[chunk][sectionOf(buckets[i])];
        }
    });
    std::array<uint32_t, kSections + 1> sectionStarts{};
    uint32_t sum = 0;
    for (uint32_t s = 0; s < sections; ++s) {
        sectionStarts[s] = sum;
        for (auto& place : places) sum += std::exchange(place[s], sum);
    }
    sectionStarts[sections] = sum;
    parallelFor(chunks, [&](size_t chunk) {
        for (size_t i = chunk * kChunk; i < std::min(n, (chunk + 1) * kChunk); ++i)
            bySection[places[chunk][sectionOf(buckets[i])]++] = static_cast<uint32_t>(i);
    });
    parallelFor(sections, [&](size_t s) {
        const std::span<const uint32_t> section(bySection.data() + sectionStarts[s],
                                                sectionStarts[s + 1] - sectionStarts[s]);
        // Counts, then the next free place of each bucket, which ends as the start of the one after.
        const auto next = starts_.begin() + static_cast<ptrdiff_t>(s * sectionBuckets) + 1;
        std::fill(next, next + sectionBuckets, 0);
        const auto bucketInSection = [&](uint32_t i) { return buckets[i] & (sectionBuckets - 1); };
        for (const uint32_t i : section) ++next[bucketInSection(i)];
        uint32_t place = sectionStarts[s];
        for (uint32_t b = 0; b < sectionBuckets; ++b) place += std::exchange(next[b], place);
        for (const uint32_t i : section)
            std::construct_at(&entries_[next[bucketInSection(i)]++],
                              Entry{positions[indexOf(i)], static_cast<uint32_t>(indexOf(i))});
    });
    starts_[0] = 0;
}

void VertexGrid::build(const PointSpan& positions, float radius) {
    sort(
        positions, positions.size(), [](size_t i) { return i; }, radius);
}

void VertexGrid::build(const PointSpan& positions, std::span<const uint32_t> indices, float radius) {
    sort(
        positions, indices.size(), [indices](size_t i) { return indices[i]; }, radius);
}

void VertexGrid::clear() {
    entries_.clear();
    starts_.clear();
}

}  // namespace metrolux::core
