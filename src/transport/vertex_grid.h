#pragma once
#include "base/uninitialized.h"
#include "transport/vertex.h"

#include <array>
#include <span>
#include <vector>

namespace metrolux::core {

/// Hash grid over the eye vertices (or other points) of an iteration, counting-sorted into buckets. Cells are
/// two radii wide, so that a ball of one radius touches at most eight of them, which are in three blocks of
/// cells (transport/cell_blocks.h) on average.
class VertexGrid {
  public:
    /// Keeps positions and indices, not the vertices. `radius` > 0, finite.
    void build(std::span<const Vertex> vertices, float radius);
    void buildPoints(std::span<const Vec3f> points, float radius);
    void clear();
    float radius() const { return radius_; }
    size_t memoryBytes() const {
        return entries_.capacity() * sizeof(Entry) + starts_.capacity() * sizeof(uint32_t);
    }

    /// Calls visit(index) for each vertex within the radius of p, once, in an order that depends on the
    /// vertices only.
    template <class Visit>
    void query(const Vec3f& p, Visit&& visit) const {
        if (empty()) return;
        const Cells cells = locate(p);
        prefetchEntries(cells);
        findWithin(p, cells, [&](const Entry& e) {
            visit(e.index);
            return false;
        });
    }

    /// Whether any vertex lies within the radius of p.
    bool anyWithin(const Vec3f& p) const {
        if (empty()) return false;
        const Cells cells = locate(p);
        prefetchEntries(cells);
        return findWithin(p, cells, [](const Entry&) { return true; });
    }

    /// The buckets of the cells that a ball touches, all different.
    struct Cells {
        std::array<uint32_t, 8> buckets;
        uint32_t count = 0;
    };
    /// A query in three steps, between which a caller with other work has it done while memory answers:
    /// locate(), prefetchEntries() and addWithin() with their result. Not when empty().
    Cells locate(const Vec3f& p) const;
    void prefetchEntries(const Cells& cells) const;
    /// Appends the indices that query() would visit, in its order.
    void addWithin(const Vec3f& p, const Cells& cells, UninitializedVector<uint32_t>& indices) const;
    bool empty() const { return entries_.empty(); }

  private:
    struct Entry {
        Vec3f position;
        uint32_t index;
    };
    template <class PositionOf>
    void buildFrom(size_t n, float radius, PositionOf&& positionOf);
    /// Calls accept(entry) for those within the radius until it returns true; returns whether it did.
    template <class Accept>
    bool findWithin(const Vec3f& p, const Cells& cells, Accept&& accept) const {
        for (uint32_t c = 0; c < cells.count; ++c) {
            const uint32_t bucket = cells.buckets[c], end = starts_[bucket + 1];
            for (uint32_t i = starts_[bucket]; i < end; ++i) {
                const Entry& e = entries_[i];
                if (lengthSquared(e.position - p) <= radiusSquared_ && accept(e)) return true;
            }
        }
        return false;
    }

    float radius_ = 0, radiusSquared_ = 0;
    double inverseCell_ = 0;
    uint32_t blockMask_ = 0;  ///< number of blocks, a power of two, less one
    std::vector<uint32_t, HugePageAllocator<uint32_t>> starts_;
    UninitializedVector<Entry> entries_;
};

}  // namespace metrolux::core
