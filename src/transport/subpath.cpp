#include "transport/subpath.h"

namespace metrolux::core {

namespace {

/// Goes on from a first vertex until the walk ends.
void continueWalk(const WalkRules& walk, SampleStream& stream, SubpathVisitor& visitor, Vertex& v) {
    const int limit = walk.depthLimit();
    bool certain = walk.mode == TransportMode::Radiance;
    weighMerging(walk, certain, v);
    while (visitor.surface(v) && v.depth < limit) {
        WalkEdge edge;
        if (!scatter(walk, stream, v, edge) || !visitor.scattered(edge.delta)) return;
        const Vec3f from = v.si.p;
        const bool found = walk.scene.intersect(edge.ray, v.si);
        if (!passMedia(walk, stream, v.depth + 1, found, edge, v)) {
            visitor.escaped(from, edge, v.depth + 1);
            return;
        }
        if (!arrive(edge, from, certain, v)) return;
        weighMerging(walk, certain, v);
    }
}

}  // namespace

void traceEyeSubpath(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                     const Strategies& strategies, const Vec2f& raster, float weight, uint32_t pixel,
                     SubpathVisitor& visitor) {
    const WalkRules walk{scene, limits, strategies, TransportMode::Radiance};
    WalkEdge first;
    if (!startEye(walk, read(stream, layout::kLens), raster, weight, first)) return;
    Vertex v;
    const bool found = scene.intersect(first.ray, v.si);
    if (!passMedia(walk, stream, 1, found, first, v)) {
        visitor.escaped(first.ray.origin, first, 1);
        return;
    }
    if (arriveFromCamera(walk, first, pixel, v)) continueWalk(walk, stream, visitor, v);
}

void traceLightSubpath(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                       const Strategies& strategies, SubpathVisitor& visitor) {
    const WalkRules walk{scene, limits, strategies, TransportMode::Importance};
    LightStart start;
    if (!startLight(walk, stream, start)) return;
    Vertex v;
    const bool found = scene.intersect(start.ray, v.si);
    if (passMedia(walk, stream, found, start, v) && arriveFromLight(walk, start, v))
        continueWalk(walk, stream, visitor, v);
}

}  // namespace metrolux::core
