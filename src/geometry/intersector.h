#pragma once
#include "geometry/ray_batch.h"
#include "geometry/shape.h"

#include <memory>
#include <string>
#include <vector>

namespace metrolux::core {

/// Rays that the process has traced, for --stats and progress: counted per thread, summed when read. Threads
/// are shared, so that a count between two readings has the rays of everything that rendered in between.
struct RayStatistics {
    uint64_t intersectRays = 0;
    uint64_t shadowRays = 0;
    double secondsInEmbree = 0;  ///< thread-seconds, from a timed subset of the rays (1 in 64), scaled up

    RayStatistics& operator+=(const RayStatistics& other) {
        intersectRays += other.intersectRays;
        shadowRays += other.shadowRays;
        secondsInEmbree += other.secondsInEmbree;
        return *this;
    }
    RayStatistics operator-(const RayStatistics& before) const {
        return {intersectRays - before.intersectRays, shadowRays - before.shadowRays,
                secondsInEmbree - before.secondsInEmbree};
    }
    uint64_t all() const { return intersectRays + shadowRays; }
};

/// Ray queries against all shapes of a scene (Embree). Immutable and thread-safe after construction.
class Intersector {
  public:
    /// Groups of so many triangles, most of which have a common edge with the one before or after (as those
    /// of a mesh of quadrilaterals), are given to Embree in pairs. The tree is half as large, so that with
    /// millions less of it misses the caches; with fewer it is no faster (docs/lab/performance.md).
    static constexpr size_t kPairFrom = 250'000;

    Intersector(const std::vector<ShapePtr>& shapes, const std::vector<Instance>& instances,
                size_t pairFrom = kPairFrom);
    ~Intersector();
    Intersector(const Intersector&) = delete;
    Intersector& operator=(const Intersector&) = delete;

    /// Nearest hit. The origin must have been moved off its own surface (offsetRayOrigin).
    bool intersect(const Ray& ray, SurfaceInteraction& si) const;
    /// Whether anything lies within (0, ray.tMax); nothing does where that is empty.
    bool occluded(const Ray& ray) const;

    /// The same for many rays at once: fills `hits`.
    void intersect(RayBatch& batch, Coherence coherence = Coherence::None) const;
    /// The point of the i-th ray's hit, which was found.
    void interaction(const RayBatch& batch, size_t i, SurfaceInteraction& si) const;
    /// For a loop over the hits: asks for the memory that interaction() will read for those after the i-th.
    void prefetchAfter(const RayBatch& batch, size_t i) const;
    /// Fills `blocked`.
    void occluded(OcclusionBatch& batch, Coherence coherence = Coherence::None) const;

    /// Whether intersect() would find a hit, by the same query of Embree: what tracing alone costs.
    bool meets(const Ray& ray) const;

    void bounds(Vec3f& lower, Vec3f& upper) const;
    /// Rays that the machine traces as a whole, 1, 4, 8 or 16.
    int packetWidth() const;
    /// Embree's version, "3.13.5".
    static std::string libraryVersion();
    /// Since the process began.
    static RayStatistics statistics();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Moves p off the surface to the side of `direction`, by a distance that is safe at any coordinate: as in
/// Waechter & Binder 2019 (A Fast and Robust Method for Avoiding Self-Intersection) it is counted in units of
/// the last place, here of the largest coordinate, because curved and tilted surfaces mix the rounding of all
/// three.
inline Vec3f offsetRayOrigin(const Vec3f& p, const Vec3f& ng, const Vec3f& direction) {
    // Hits are rounded to float once (triangle_mesh.cpp, sphere.cpp ...): half a unit in the last place of
    // each coordinate. What remains is the intersector's own error, of a few units of the coordinates of the
    // triangle. 64 units cover both with a wide margin and are 4e-6 of the distance to the origin;
    // tests/unit/geometry/self_intersection_test.cpp measures it. Coordinates below one count as one:
    // triangles are rarely as small as their distance to the origin.
    constexpr float kRelativeOffset = 0x1p-18f;
    const float largest = std::max(std::max(std::abs(p.x), std::abs(p.y)), std::max(std::abs(p.z), 1.0f));
    const float distance = kRelativeOffset * largest;
    return p + ng * (dot(ng, direction) < 0 ? -distance : distance);
}

}  // namespace metrolux::core
