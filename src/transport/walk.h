#pragma once
#include "sampling/sample_stream.h"
#include "scene/scene.h"
#include "transport/light_edge.h"
#include "transport/passage.h"
#include "transport/primary_layout.h"
#include "transport/vertex.h"

namespace metrolux::core {

/// The steps of a random walk, which one subpath takes alone (subpath.h) and many take side by side
/// (wavefront/). The only home of throughput, roulette, the adjoint correction and the MIS
/// recursion.

/// The edge of a subpath that is to be traced next.
struct WalkEdge {
    Ray ray;
    Rgb throughput{0.0f};
    MisState mis;            ///< after scattering, before arrival
    bool delta = false;      ///< scattered by a delta lobe
    bool dispersed = false;  ///< Vertex::dispersed of what it leaves, or it has crossed such a surface
    // In scenes with media:
    MediumIndex medium = 0;  ///< in which the ray starts
    Rgb stop{1.0f};          ///< stopDensity() of the vertex at its start
};

/// What is the same for all vertices of a walk.
struct WalkRules {
    const Scene& scene;
    const PathLimits& limits;
    const Strategies& strategies;
    TransportMode mode;

    /// Subpaths of unlimited depth end here; roulette has long since ended any that lose energy.
    static constexpr int kDepthCap = 512;
    int depthLimit() const { return limits.maxDepth < 0 ? kDepthCap : std::min(limits.maxDepth, kDepthCap); }
    bool plays(int depth) const { return depth >= limits.rouletteDepth; }
    /// Block of the numbers of a vertex.
    int block(int depth) const { return layout::blockOf(depth, scene.hasMedia()); }
};

/// Chooses the next direction at `v`: `uLobe` picks the lobe, `u` the direction. `roulette()` gives the
/// number for roulette where it plays. False when the walk ends.
template <class Roulette>
bool scatter(const WalkRules& walk, const Vertex& v, float uLobe, const Vec2f& u, Roulette&& roulette,
             WalkEdge& next) {
    /// Survival probability never exceeds this once roulette is on, so that lossless scenes end.
    constexpr float kMaximalSurvival = 0.95f;
    const Vec3f known = v.si.toLocal(v.toPrevious);
    const std::optional<BsdfSample> s = v.sample(known, walk.mode, uLobe, u);
    if (!s) return false;
    const Vec3f direction = normalize(v.si.toWorld(s->direction));

    next.throughput = v.throughput * s->weight;
    if (walk.mode == TransportMode::Importance) next.throughput *= lightSampleFactor(v, direction);

    if (walk.plays(v.depth)) {
        // Local quantities only: the survival probability does not depend on how the walk came here.
        const float survival = std::min(maxComponent(v.albedo()), kMaximalSurvival);
        if (!(roulette() < survival)) return false;
        next.throughput *= 1.0f / survival;
    }
    if (isBlack(next.throughput)) return false;

    const double cosine = v.cosine(direction);
    if (!(cosine > 0)) return false;
    next.mis = v.mis;
    next.dispersed = v.dispersed;
    next.delta = s->delta;
    if (s->delta) {
        double solidAngleRatio = 1;
        if (s->transmitted)
            solidAngleRatio = absCosTheta(known) / (double(absCosTheta(s->direction)) * s->eta * s->eta);
        next.mis.scatterDelta(cosine, s->pdfReverse / s->pdfForward, solidAngleRatio);
    } else {
        next.mis.scatter(walk.strategies, cosine, s->pdfForward, s->pdfReverse);
    }
    next.ray = {offsetRayOrigin(v.si.p, v.si.ng, direction), direction, kInfinity};
    if (walk.scene.hasMedia()) {
        next.medium = mediumBeyond(v, direction);
        next.stop = v.stopDensity(direction);
    }
    return true;
}

/// The same with the numbers of the vertex's block of `stream`.
inline bool scatter(const WalkRules& walk, SampleStream& stream, const Vertex& v, WalkEdge& next) {
    const int block = walk.block(v.depth);
    const float uLobe = read(stream, layout::kLobe, block);
    const Vec2f u = read(stream, layout::kDirection, block);
    return scatter(
        walk, v, uLobe, u, [&] { return read(stream, layout::kRoulette, block); }, next);
}

/// To be called between tracing an edge of an eye subpath, or one after the first of a light subpath, and
/// arriving: in scenes with media, where its end may be another than the surface at v.si that was `found`, if
/// any. `depth`: of the vertex where it ends. False when the walk leaves the scene.
inline bool passMedia(const WalkRules& walk, SampleStream& stream, int depth, bool found, WalkEdge& edge,
                      Vertex& v) {
    if (!walk.scene.hasMedia()) return found;
    v.medium = edge.medium;
    v.si.wavelength = walk.strategies.wavelength.nanometers;
    const WalkPassage passage =
        walkAlong(walk.scene, edge.ray, edge.stop,
                  read(stream, layout::kDistance, layout::distanceBlockOf(depth)), found, v);
    edge.throughput *= passage.weight;
    edge.dispersed |= passage.dispersed;
    edge.mis.pass(passage.forward, passage.reverse);
    return passage.ends;
}

/// The vertex before has become the one where `edge` ends: `v.si` is the hit, everything else still that of
/// the vertex at `from`. `certain`: whether an eye subpath has met no smooth surface before, so that its next
/// vertex is not there by chance. False when the walk ends. weighMerging() is still to be called.
inline bool arrive(const WalkEdge& edge, const Vec3f& from, bool& certain, Vertex& v) {
    const double cosine = v.cosine(edge.ray.direction);
    if (!(cosine > 0)) return false;
    v.distanceToPrevious = (v.si.p - from).length();
    v.mis = edge.mis;
    v.mis.arrive(sqr(double(v.distanceToPrevious)), cosine);
    v.toPrevious = -edge.ray.direction;
    v.throughput = edge.throughput;
    v.dispersed = edge.dispersed || v.isDispersive();
    certain &= edge.delta;
    ++v.depth;
    return true;
}

/// Sets v.mis.mergeShare. By itself, because it waits for the memory of Strategies::photons.
inline void weighMerging(const WalkRules& walk, bool certain, Vertex& v) {
    v.mis.mergeShare = v.inMedium || certain
                           ? static_cast<float>(walk.strategies.certainMergeShare(v.inMedium))
                           : static_cast<float>(walk.strategies.mergeShare(v.si.p));
}

/// The first edge of an eye subpath, from the camera through `raster`. False when no light can come that way.
inline bool startEye(const WalkRules& walk, const Vec2f& uLens, const Vec2f& raster, float weight,
                     WalkEdge& first) {
    const Camera& camera = walk.scene.camera();
    const std::optional<EndpointRay> start = camera.sampleRay(uLens, raster);
    if (!start) return false;
    first.mis =
        MisState::startEye(walk.strategies, camera.isInfinite() ? start->pdfPosition : start->pdfDirection,
                           walk.strategies.regionOf(raster));
    first.throughput = start->weight * weight;
    first.ray = {start->origin, start->direction, kInfinity};
    first.medium = walk.scene.cameraMedium();
    return true;
}

/// As arrive(), at the first vertex, which is certain.
inline bool arriveFromCamera(const WalkRules& walk, const WalkEdge& first, uint32_t pixel, Vertex& v) {
    const Camera& camera = walk.scene.camera();
    const double cosine = v.cosine(first.ray.direction);
    if (!(cosine > 0)) return false;
    // The camera's ray may start at a near plane: distances count from the center of projection.
    const Vec3f origin = camera.isInfinite() ? first.ray.origin
                                             : camera.projectionCenter(first.ray.origin, first.ray.direction);
    v.distanceToPrevious = (v.si.p - origin).length();
    v.mis = first.mis;
    v.mis.arrive(camera.isInfinite() ? 1.0 : sqr(double(v.distanceToPrevious)), cosine);
    v.toPrevious = -first.ray.direction;
    v.throughput = first.throughput;
    v.si.wavelength = walk.strategies.wavelength.nanometers;
    v.dispersed = first.dispersed || v.isDispersive();
    v.pixel = pixel;
    v.depth = 1;
    return true;
}

/// The first edge of a light subpath, by the numbers of block 0. False when nothing is emitted.
inline bool startLight(const WalkRules& walk, SampleStream& stream, LightStart& start) {
    float uLight = read(stream, layout::kEmitter);
    const Vec2f uPosition = read(stream, layout::kEmissionPoint);
    const Vec2f uDirection = read(stream, layout::kEmissionDirection);
    start.choice = walk.scene.chooseLightForEmission(uLight);
    if (!start.choice.light) return false;
    const std::optional<EndpointRay> point = start.choice.light->sampleRay(uPosition, uDirection);
    if (!point || isBlack(point->weight)) return false;
    start.point = *point;
    const bool surface = point->ng != Vec3f(0.0f);
    start.ray = {surface ? offsetRayOrigin(point->origin, point->ng, point->direction) : point->origin,
                 point->direction, kInfinity};
    return true;
}

/// As passMedia(), for the first edge of a light subpath.
inline bool passMedia(const WalkRules& walk, SampleStream& stream, bool found, LightStart& start, Vertex& v) {
    if (!walk.scene.hasMedia()) return found;
    const float u = read(stream, layout::kDistance, layout::distanceBlockOf(1));
    v.medium = walk.scene.mediumOf(*start.choice.light, start.point);
    v.si.wavelength = walk.strategies.wavelength.nanometers;
    start.passage = walkAlong(walk.scene, start.ray, Rgb(1.0f), u, found, v);
    start.point.weight *= start.passage.weight;
    return start.passage.ends;
}

/// As arrive(), at the first vertex.
inline bool arriveFromLight(const WalkRules& walk, const LightStart& start, Vertex& v) {
    const EndpointRay& point = start.point;
    if (!(v.cosine(point.direction) > 0)) return false;
    v.distanceToPrevious = (v.si.p - point.origin).length();
    v.toPrevious = -point.direction;
    v.throughput = point.weight * (1.0f / start.choice.probability);
    v.si.wavelength = walk.strategies.wavelength.nanometers;
    v.dispersed = start.passage.dispersed || v.isDispersive();
    v.mis = MisState::arriveFromLight(walk.strategies, emittedEdge(walk.scene, start, v));
    v.depth = 1;
    return true;
}

}  // namespace metrolux::core
