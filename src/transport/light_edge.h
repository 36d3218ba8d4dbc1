#pragma once
/// The first edge of a path as each technique finds it: sampled from the light, by next-event estimation, or
/// hit by an eye subpath. All densities of an emitter become those of LightEdge here.

#include "transport/passage.h"

namespace metrolux::core {

inline EndpointKind kindOf(const Light& light) {
    if (light.isInfinite()) return EndpointKind::Infinite;
    return light.isDelta() ? EndpointKind::DeltaPosition : EndpointKind::Surface;
}

/// How a light subpath begins.
struct LightStart {
    Scene::LightChoice choice;
    EndpointRay point;
    Ray ray;
    WalkPassage passage{true, Rgb(1.0f)};  ///< through media
};

/// Emitted: a light subpath has arrived at x1.
inline LightEdge emittedEdge(const Scene& scene, const LightStart& start, const Vertex& x1) {
    const Light& light = *start.choice.light;
    const EndpointRay& x0 = start.point;
    LightEdge edge;
    edge.kind = kindOf(light);
    edge.delta = light.isDelta();
    edge.pdfPosition = x0.pdfPosition;
    edge.pdfDirection = double(x0.pdfDirection) * start.choice.probability;
    edge.cosineLight = x0.cosine;
    edge.cosineSurface = x1.cosine(x0.direction);
    edge.distanceSquared = sqr(double(x1.distanceToPrevious));
    edge.arrival = start.passage.forward;
    edge.arrivalAtLight = start.passage.reverse;
    // Zero for a light that next-event estimation cannot reach (a collimated beam): then nee is no technique.
    edge.pdfNee = light.isConnectable() ? scene.connectionProbability(x1.si.p, &light) : 0.0;
    if (edge.kind == EndpointKind::Surface)
        edge.pdfNee *= light.densities(x1.si.p, x0.surface).connect;
    else if (!edge.delta)
        edge.pdfNee *= light.environmentDensities(x1.si.p, -x0.direction).connect;
    return edge;
}

/// Next-event estimation at x1 has chosen a light and, as `x0`, a point on it.
inline LightEdge neeEdge(const Scene::LightChoice& choice, const EndpointConnection& x0, const Vertex& x1) {
    LightEdge edge;
    edge.kind = kindOf(*choice.light);
    edge.delta = choice.light->isDelta();
    edge.pdfNee = double(x0.pdf) * choice.probability;
    edge.pdfPosition = x0.pdfPosition;
    edge.pdfDirection = double(x0.pdfDirection) * choice.emissionProbability;
    edge.cosineLight = x0.cosine;
    edge.cosineSurface = x1.cosine(x0.wi);
    edge.distanceSquared = sqr(double(x0.distance));
    return edge;
}

/// An eye subpath from x1 ends on a light with the densities d. (cosineSurface stays 1: it is known from x1
/// only, and no weight of a hit asks for it.)
inline LightEdge hitEdge(const Scene& scene, const Light& light, const EndpointDensities& d,
                         const Vec3f& x1) {
    LightEdge edge;
    edge.kind = kindOf(light);
    edge.pdfNee = double(scene.connectionProbability(x1, &light)) * d.connect;
    edge.pdfPosition = d.pdfPosition;
    edge.pdfDirection = double(d.pdfDirection) * scene.emissionProbability(&light);
    return edge;
}
/// An eye subpath has hit an area light at x0.
inline LightEdge surfaceHitEdge(const Scene& scene, const Vertex& x0) {
    const Vec3f x1 = x0.si.p + x0.toPrevious * x0.distanceToPrevious;
    const Light& light = *x0.emitter();
    LightEdge edge = hitEdge(scene, light, light.densities(x1, x0.si), x1);
    edge.cosineLight = x0.cosine(x0.toPrevious);
    edge.distanceSquared = sqr(double(x0.distanceToPrevious));
    return edge;
}
/// An eye subpath leaves the scene from x1 in `direction`, toward the environment.
inline LightEdge environmentHitEdge(const Scene& scene, const Light& environment, const Vec3f& x1,
                                    const Vec3f& direction) {
    return hitEdge(scene, environment, environment.environmentDensities(x1, direction), x1);
}

}  // namespace metrolux::core
