#include "transport/subpath.h"

namespace metrolux {

namespace {

/// Subpaths of unlimited depth end here; roulette has long since ended any that lose energy.
constexpr int kDepthCap = 512;
/// Survival probability never exceeds this once roulette is on, so that lossless scenes end.
constexpr float kMaximalSurvival = 0.95f;

/// What differs between the two directions of a walk.
struct Walk {
    const Scene& scene;
    SampleStream& stream;
    const PathLimits& limits;
    const Strategies& strategies;
    SubpathVisitor& visitor;
    TransportMode mode;
};

/// Chooses the next direction at `v` and updates throughput and weights. The only home of throughput,
/// roulette, the adjoint correction and the MIS recursion. False when the walk ends. `delta`: by a delta
/// lobe.
bool scatter(const Walk& walk, const Vertex& v, Ray& ray, Rgb& throughput, MisState& mis, bool& delta) {
    const Bsdf& bsdf = v.bsdf();
    walk.stream.seek(v.depth);
    const float uLobe = walk.stream.next1D();
    const Vec2f u = walk.stream.next2D();

    const Vec3f known = v.si.toLocal(v.toPrevious);
    const std::optional<BsdfSample> s = bsdf.sample(v.si, known, walk.mode, uLobe, u);
    if (!s) return false;
    const Vec3f direction = normalize(v.si.toWorld(s->direction));

    throughput = v.throughput * s->weight;
    if (walk.mode == TransportMode::Importance) throughput *= lightSampleFactor(v, direction);

    if (v.depth >= walk.limits.rouletteDepth) {
        // Local quantities only: the survival probability does not depend on how the walk came here.
        const float survival = std::min(maxComponent(bsdf.albedo(v.si)), kMaximalSurvival);
        if (!(walk.stream.next1D() < survival)) return false;
        throughput *= 1.0f / survival;
    }
    if (isBlack(throughput)) return false;

    const double cosine = absDot(direction, v.si.ng);
    if (!(cosine > 0)) return false;
    mis = v.mis;
    delta = s->delta;
    if (s->delta) {
        double solidAngleRatio = 1;
        if (s->transmitted)
            solidAngleRatio = absCosTheta(known) / (double(absCosTheta(s->direction)) * s->eta * s->eta);
        mis.scatterDelta(cosine, s->pdfReverse / s->pdfForward, solidAngleRatio);
    } else {
        mis.scatter(walk.strategies, cosine, s->pdfForward, s->pdfReverse, v.mergeShare);
    }
    ray = {offsetRayOrigin(v.si.p, v.si.ng, direction), direction, kInfinity};
    return true;
}

int depthLimit(const PathLimits& limits) {
    return limits.maxDepth < 0 ? kDepthCap : std::min(limits.maxDepth, kDepthCap);
}

/// Goes on from a first vertex until the walk ends.
void continueWalk(const Walk& walk, Vertex& v) {
    const int limit = depthLimit(walk.limits);
    // Whether the vertex is the first smooth one that a camera's ray meets: not there by chance.
    bool certain = walk.mode == TransportMode::Radiance;
    if (!certain) v.mergeShare = static_cast<float>(walk.strategies.mergeShare(v.si.p));
    while (walk.visitor.surface(v) && v.depth < limit) {
        Ray ray;
        Rgb throughput;
        MisState mis;
        bool delta = false;
        if (!scatter(walk, v, ray, throughput, mis, delta) || !walk.visitor.scattered(delta)) return;
        const Vec3f from = v.si.p;
        if (!walk.scene.intersect(ray, v.si)) {
            walk.visitor.escaped(from, ray.direction, throughput, mis, v.depth + 1);
            return;
        }
        const double cosine = absDot(ray.direction, v.si.ng);
        if (!(cosine > 0)) return;
        v.distanceToPrevious = (v.si.p - from).length();
        mis.arrive(sqr(double(v.distanceToPrevious)), cosine);
        v.toPrevious = -ray.direction;
        v.throughput = throughput;
        v.mis = mis;
        certain &= delta;
        v.mergeShare = certain ? 1.0f : static_cast<float>(walk.strategies.mergeShare(v.si.p));
        ++v.depth;
    }
}

}  // namespace

void traceEyeSubpath(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                     const Strategies& strategies, const Vec2f& raster, float weight, uint32_t pixel,
                     SubpathVisitor& visitor) {
    stream.seek(0);
    stream.next2D();
    const std::optional<EndpointRay> start = scene.camera().sampleRay(stream.next2D(), raster);
    if (!start) return;
    const bool infinite = scene.camera().isInfinite();
    MisState mis = infinite ? MisState::startEyeInfinite(strategies, start->pdfPosition)
                            : MisState::startEye(strategies, start->pdfDirection);
    const Rgb throughput = start->weight * weight;

    const Walk walk{scene, stream, limits, strategies, visitor, TransportMode::Radiance};
    Vertex v;
    if (!scene.intersect({start->origin, start->direction, kInfinity}, v.si)) {
        visitor.escaped(start->origin, start->direction, throughput, mis, 1);
        return;
    }
    const double cosine = absDot(start->direction, v.si.ng);
    if (!(cosine > 0)) return;
    // The camera's ray may start at a near plane: distances count from the centre of projection.
    const Vec3f origin =
        infinite ? start->origin : scene.camera().projectionCenter(start->origin, start->direction);
    v.distanceToPrevious = (v.si.p - origin).length();
    mis.arrive(infinite ? 1.0 : sqr(double(v.distanceToPrevious)), cosine);
    v.toPrevious = -start->direction;
    v.throughput = throughput;
    v.mis = mis;
    v.pixel = pixel;
    v.depth = 1;
    continueWalk(walk, v);
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
    continueWalk({scene, stream, limits, strategies, visitor, TransportMode::Importance}, v);
}

}  // namespace metrolux
