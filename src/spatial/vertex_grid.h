#pragma once
#include "base/uninitialized.h"
#include "spatial/point_span.h"

#include <array>
#include <span>
#include <vector>

namespace metrolux::core {

/// Hash grid over the positions of the vertices of an iteration, counting-sorted into buckets. Cells are
/// two radii wide, so that a ball of one radius touches at most eight of them, which are in three blocks of
/// cells (spatial/cell_blocks.h) on average.
class VertexGrid {
  public:
    /// Copies the positions and keeps their indices. `radius` > 0, finite.
    void build(const PointSpan& positions, float radius);
    /// Of those positions only that `indices` name.
    void build(const PointSpan& positions, std::span<const uint32_t> indices, float radius);
    void clear();
    float radius() const { return radius_; }
    size_t memoryBytes() const {
        return entries_.capacity() * sizeof(Entry) + starts_.capacity() * sizeof(uint32_t);
    }

    /// Calls visit(index) for each vertex within the radius of p, once, in an order that depends on the
    /// vertices only.
    template <class Visit>
    void query(const Vec3f& p, Visit&& visit) const {
        find(p, [&](uint32_t index) {
            visit(index);
            return false;
        });
    }

    /// Whether any vertex lies within the radius of p.
    bool anyWithin(const Vec3f& p) const {
        return find(p, [](uint32_t) { return true; });
    }
    bool empty() const { return entries_.empty(); }

    // What a query is made of, for those who make many together (wavefront/prefetching.h). Not when empty().

    struct Entry {
        Vec3f position;
        uint32_t index;
    };
    /// The buckets of the cells that a ball touches, all different.
    struct Cells {
        std::array<uint32_t, 8> buckets;
        uint32_t count = 0;
        std::span<const uint32_t> all() const { return {buckets.data(), count}; }
    };
    Cells cellsOf(const Vec3f& p) const;
    std::span<const Entry> entriesOf(uint32_t bucket) const {
        return {entries_.data() + starts_[bucket], entries_.data() + starts_[bucket + 1]};
    }
    bool isWithin(const Entry& e, const Vec3f& p) const {
        return lengthSquared(e.position - p) <= radiusSquared_;
    }
    /// Of what entriesOf(bucket) reads.
    const void* addressOf(uint32_t bucket) const { return &starts_[bucket]; }

  private:
    template <class IndexOf>
    void sort(const PointSpan& positions, size_t n, IndexOf&& indexOf, float radius);
    /// Calls accept(index) for those within the radius until it returns true; returns whether it did.
    template <class Accept>
    bool find(const Vec3f& p, Accept&& accept) const {
        if (empty()) return false;
        for (const Cells cells = cellsOf(p); const uint32_t bucket : cells.all())
            for (const Entry& e : entriesOf(bucket))
                if (isWithin(e, p) && accept(e.index)) return true;
        return false;
    }

    float radius_ = 0, radiusSquared_ = 0;
    double inverseCell_ = 0;
    uint32_t blockMask_ = 0;                ///< number of blocks, a power of two, less one
    UninitializedVector<uint32_t> starts_;  ///< of each bucket in entries_, and the end
    UninitializedVector<Entry> entries_;
};

}  // namespace metrolux::core
