#pragma once
#include "sampling/sample_stream.h"
#include "scene/scene.h"
#include "transport/walk.h"

namespace metrolux::core {

/// What a subpath does with its vertices. Each call may end the walk.
class SubpathVisitor {
  public:
    virtual ~SubpathVisitor() = default;
    /// A surface vertex, before scattering. Returns whether the walk goes on.
    virtual bool surface(const Vertex& vertex) = 0;
    /// Scattered at the last vertex, by a delta lobe or not. Returns whether that direction is followed.
    virtual bool scattered(bool delta) {
        (void)delta;
        return true;
    }
    /// The walk leaves the scene along `edge`, its edge number `depth`. `from` is the last surface point, or
    /// the ray origin; edge.mis.dVCM refers to a density per solid angle.
    virtual void escaped(const Vec3f& from, const WalkEdge& edge, int depth) {
        (void)from, (void)edge, (void)depth;
    }
};

/// Random walk from the camera through `raster` (pixels of the full image), which the caller has got from the
/// stream (transport/primary_layout.h). `weight` multiplies the throughput.
void traceEyeSubpath(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                     const Strategies& strategies, const Vec2f& raster, float weight, uint32_t pixel,
                     SubpathVisitor& visitor);

/// Random walk from a light.
void traceLightSubpath(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                       const Strategies& strategies, SubpathVisitor& visitor);

}  // namespace metrolux::core
