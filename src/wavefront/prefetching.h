#pragma once
/// Asking for memory ahead of time. A wavefront does one step for all subpaths before the next step, and what
/// the next will read is on its way meanwhile.

#include "base/prefetch.h"
#include "spatial/vertex_grid.h"
#include "transport/strategies.h"

#include <algorithm>

namespace metrolux::core {

/// For Strategies::mergeShare(p).
inline void prefetchMergeShare(const Strategies& n, const Vec3f& p) {
    if (n.photons) prefetch(n.photons->addressOfLevel(n.photons->bucketOf(p)));
}

/// For PhotonDensity::count(bucket): an atomic addition waits for its memory.
inline void prefetchCounter(const PhotonDensity& photons, PhotonDensity::Bucket bucket) {
    prefetchToWrite(photons.addressOfCounter(bucket));
}

// VertexGrid::query() in three steps: cellsOf(), whose buckets are prefetched, then their entries, then the
// search.

inline void prefetchBuckets(const VertexGrid& grid, const VertexGrid::Cells& cells) {
    for (const uint32_t bucket : cells.all()) prefetch(grid.addressOf(bucket));
}
inline void prefetchEntries(const VertexGrid& grid, const VertexGrid::Cells& cells) {
    constexpr size_t kMost = 8;  // two cache lines
    for (const uint32_t bucket : cells.all()) {
        const std::span<const VertexGrid::Entry> entries = grid.entriesOf(bucket);
        if (!entries.empty()) prefetch(entries.data(), std::min(entries.size(), kMost) * sizeof(entries[0]));
    }
}
/// Appends the indices that query(p) would visit, in its order.
inline void appendWithin(const VertexGrid& grid, const Vec3f& p, const VertexGrid::Cells& cells,
                         UninitializedVector<uint32_t>& indices) {
    const size_t before = indices.size();
    size_t most = before;
    for (const uint32_t bucket : cells.all()) most += grid.entriesOf(bucket).size();
    indices.resize(most);
    // Without branches that depend on the distance: one in five is near.
    uint32_t* end = indices.data() + before;
    for (const uint32_t bucket : cells.all())
        for (const VertexGrid::Entry& e : grid.entriesOf(bucket)) {
            *end = e.index;
            end += grid.isWithin(e, p);
        }
    indices.resize(static_cast<size_t>(end - indices.data()));
}

}  // namespace metrolux::core
