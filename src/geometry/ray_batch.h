#pragma once
#include "base/math.h"

#include <cstdint>
#include <span>
#include <vector>

namespace metrolux::core {

/// What a ray met, before anything of the surface is known: Intersector::interaction makes a point of it.
struct RayHit {
    static constexpr uint32_t kNone = ~0u;
    uint32_t geometry = kNone;  ///< in its group
    uint32_t primitive = 0;     ///< triangle, or the first of a pair; 0 for analytic shapes
    uint32_t instance = kNone;  ///< geometry id of the instance, kNone outside of instances
    Vec2f uv{0.0f};             ///< Embree's: barycentric (b1, b2) of a triangle that is not in a pair

    bool found() const { return geometry != kNone; }
};

/// Rays of several subpaths that are traced together: Embree's packets share the way through the tree.
/// Each ray gets the hit that it would get alone, but where two surfaces lie at the same distance to the bit.
struct RayBatch {
    std::vector<Ray> rays;
    std::vector<RayHit> hits;  ///< of each ray, after Intersector::intersect
    /// Of hits on analytic shapes the rays in the space of their group. Empty in scenes of meshes alone.
    std::vector<Ray> localRays;

    void clear() { rays.clear(); }
    size_t size() const { return rays.size(); }
};

/// Whether rays are blocked.
struct OcclusionBatch {
    std::vector<Ray> rays;
    std::vector<uint8_t> blocked;  ///< of each ray, after Intersector::occluded

    void clear() { rays.clear(); }
    size_t size() const { return rays.size(); }
};

/// How the rays of a batch go together.
enum class Coherence : uint8_t {
    Alone,  ///< they do not: no answer depends on which others there are, not even at equal distances
    None,   ///< in packets
    High    ///< in packets traced as one bundle: they start and run close to each other, as camera rays do
};

}  // namespace metrolux::core
