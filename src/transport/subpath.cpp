#include "transport/subpath.h"

namespace metrolux {

namespace {

/// Goes on from a first vertex until the walk ends.
void continueWalk(const WalkRules& walk, SampleStream& stream, SubpathVisitor& visitor, Vertex& v) {
    const int limit = walk.depthLimit();
    bool certain = walk.mode == TransportMode::Radiance;
    if (!certain) v.mergeShare = static_cast<float>(walk.strategies.mergeShare(v.si.p));
    while (visitor.surface(v) && v.depth < limit) {
        stream.seek(v.depth);
        const float uLobe = stream.next1D();
        const Vec2f u = stream.next2D();
        WalkEdge edge;
        if (!scatter(
                walk, v, uLobe, u, [&] { return stream.next1D(); }, edge) ||
            !visitor.scattered(edge.delta))
            return;
        const Vec3f from = v.si.p;
        if (!walk.scene.intersect(edge.ray, v.si)) {
            visitor.escaped(from, edge, v.depth + 1);
            return;
        }
        v.bsdf().prefetch(v.si);
        if (!arrive(walk, edge, from, certain, v)) return;
    }
}

}  // namespace

void traceEyeSubpath(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                     const Strategies& strategies, const Vec2f& raster, float weight, uint32_t pixel,
                     SubpathVisitor& visitor) {
    stream.seek(0);
    stream.next2D();
    const WalkRules walk{scene, limits, strategies, TransportMode::Radiance};
    WalkEdge first;
    if (!startEye(walk, stream.next2D(), raster, weight, first)) return;
    Vertex v;
    if (!scene.intersect(first.ray, v.si)) {
        visitor.escaped(first.ray.origin, first, 1);
        return;
    }
    if (arriveFromCamera(walk, first, pixel, v)) continueWalk(walk, stream, visitor, v);
}

void traceLightSubpath(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                       const Strategies& strategies, SubpathVisitor& visitor) {
    stream.seek(0);
    float uLight = stream.next1D();
    const Vec2f uPosition = stream.next2D(), uDirection = stream.next2D();
    const Scene::LightChoice choice = scene.chooseLightForEmission(uLight);
    if (!choice.light) return;
    const std::optional<EndpointRay> start = choice.light->sampleRay(uPosition, uDirection);
    if (!start || isBlack(start->weight)) return;

    const bool surface = start->ng != Vec3f(0.0f);
    const Vec3f origin =
        surface ? offsetRayOrigin(start->origin, start->ng, start->direction) : start->origin;
    Vertex v;
    if (!scene.intersect({origin, start->direction, kInfinity}, v.si)) return;

    LightEdge edge;
    edge.kind = choice.light->isInfinite() ? EndpointKind::Infinite
                : choice.light->isDelta()  ? EndpointKind::DeltaPosition
                                           : EndpointKind::Surface;
    edge.delta = choice.light->isDelta();
    edge.position = start->pdfPosition;
    edge.direction = double(start->pdfDirection) * choice.probability;
    edge.cosineLight = start->cosine;
    edge.cosineSurface = absDot(start->direction, v.si.ng);
    v.distanceToPrevious = (v.si.p - start->origin).length();
    edge.distanceSquared = sqr(double(v.distanceToPrevious));
    if (!(edge.cosineSurface > 0)) return;
    // Zero for a light that next-event estimation cannot reach (a collimated beam): then nee is no technique.
    edge.connect = choice.light->isConnectable() ? scene.connectionProbability(v.si.p, choice.light) : 0.0;
    if (edge.kind == EndpointKind::Surface)
        edge.connect *= choice.light->densities(v.si.p, start->surface).connect;
    else if (!edge.delta)
        edge.connect *= choice.light->environmentDensities(v.si.p, -start->direction).connect;

    v.toPrevious = -start->direction;
    v.throughput = start->weight * (1.0f / choice.probability);
    v.mis = MisState::arriveFromLight(strategies, edge, edge.emissionOverConnection());
    v.depth = 1;
    continueWalk({scene, limits, strategies, TransportMode::Importance}, stream, visitor, v);
}

}  // namespace metrolux
