#pragma once
#include "transport/vertex.h"

#include <tbb/cache_aligned_allocator.h>

#include <array>
#include <span>
#include <vector>

namespace metrolux {

/// Hash grid over the eye vertices (or other points) of an iteration, counting-sorted into buckets. Cells are
/// two radii wide, so that a ball of one radius touches at most eight of them. Blocks of 4 x 2 x 2 cells are
/// hashed as one and their buckets lie side by side in a cache line: these eight cells are in three lines on
/// average.
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
        findWithin(p, [&](const Entry& e) {
            visit(e.index);
            return false;
        });
    }

    /// Whether any vertex lies within the radius of p.
    bool anyWithin(const Vec3f& p) const {
        return findWithin(p, [](const Entry&) { return true; });
    }

  private:
    struct Entry {
        Vec3f position;
        uint32_t index;
    };
    template <class PositionOf>
    void buildFrom(size_t n, float radius, PositionOf&& positionOf);
    /// Calls accept(entry) for those within the radius until it returns true; returns whether it did.
    template <class Accept>
    bool findWithin(const Vec3f& p, Accept&& accept) const {
        if (entries_.empty()) return false;
        std::array<std::span<const Entry>, 8> buckets;
        const int count = bucketsAround(p, buckets);
        for (int b = 0; b < count; ++b)
            for (const Entry& e : buckets[b])
                if (lengthSquared(e.position - p) <= radiusSquared_ && accept(e)) return true;
        return false;
    }
    uint32_t bucketOf(int64_t x, int64_t y, int64_t z) const;
    /// Distinct non-empty buckets of the cells that the ball around p touches: cells that hash alike are
    /// visited once.
    int bucketsAround(const Vec3f& p, std::array<std::span<const Entry>, 8>& buckets) const;

    float radius_ = 0, radiusSquared_ = 0;
    double inverseCell_ = 0;
    uint32_t blockMask_ = 0;
    std::vector<uint32_t, tbb::cache_aligned_allocator<uint32_t>> starts_;
    std::vector<Entry> entries_;
};

}  // namespace metrolux
