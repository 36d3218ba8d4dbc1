#include "transport/passage.h"

#include "media/medium_point.h"

namespace metrolux::core {

namespace {

/// Surfaces that an edge crosses at most; more can only be rays that are stuck in one.
constexpr int kMostCrossings = 10'000;

Rgb exponential(const Rgb& thickness) {
    return {std::exp(-thickness.x), std::exp(-thickness.y), std::exp(-thickness.z)};
}

/// What an edge has met so far.
struct Met {
    Rgb thickness{0.0f};   ///< of what a walk may stop at
    Rgb absorption{0.0f};  ///< thickness of what it may not
    Rgb factor{1.0f};      ///< of crossed surfaces, over the probability of crossing them
    bool dispersed = false;

    void cross(const SurfaceInteraction& si, const NullLobe& lobe) {
        dispersed |= si.wavelength > 0 && si.shape->bsdf->isDispersive();
        factor *= lobe.transmittance * (1 / lobe.probability);
        if (lobe.probability < 1) thickness += Rgb(-std::log(lobe.probability));
    }
    Passage passage() const {
        const Rgb survival = exponential(thickness);
        return {factor * survival * exponential(absorption), survival, dispersed};
    }
};

/// The null lobe of the surface that is met, of probability 0 where it has none or is a vertex nevertheless:
/// lamps are.
NullLobe nullLobeAt(const SurfaceInteraction& si, const Vec3f& direction) {
    const Shape& shape = *si.shape;
    if (!shape.bsdf->hasNullLobe() || shape.emitter) return {};
    return shape.bsdf->nullLobe(si, si.toLocal(-direction));
}

}  // namespace

Passage passAlong(const Scene& scene, const Ray& ray, MediumIndex medium, float wavelength) {
    const Vec3f& w = ray.direction;
    Met met;
    Ray rest = ray;
    for (int crossings = 0; rest.tMax > 0; ++crossings) {
        SurfaceInteraction si;
        si.wavelength = wavelength;
        const bool found = scene.intersect(rest, si);
        const float length = found ? std::min((si.p - rest.origin).length(), rest.tMax) : rest.tMax;
        if (const Medium* m = scene.medium(medium))
            (m->scatters() ? met.thickness : met.absorption) += m->thickness(rest.origin, w, length);
        if (!found) break;
        const NullLobe lobe = nullLobeAt(si, w);
        if (!(lobe.probability > 0) || crossings == kMostCrossings) return {Rgb(0.0f), Rgb(0.0f)};
        met.cross(si, lobe);
        medium = mediumBeyond(si, w, medium);
        const Vec3f origin = offsetRayOrigin(si.p, si.ng, w);
        rest.tMax = ray.tMax - dot(origin - ray.origin, w);
        rest.origin = origin;
    }
    return met.passage();
}

WalkPassage walkAlong(const Scene& scene, const Ray& ray, const Rgb& stop, float u, bool found, Vertex& v) {
    // One number leads through all media and surfaces: a channel, and the thickness at which the walk stops.
    const float scaled = u * 3;
    const int channel = std::min(static_cast<int>(scaled), 2);
    const float target = -std::log1p(-std::min(scaled - static_cast<float>(channel), kOneMinusEpsilon));

    const Vec3f& w = ray.direction;
    Met met;
    Vec3f origin = ray.origin;
    WalkPassage result;
    for (int crossings = 0;; ++crossings) {
        if (const Medium* m = scene.medium(v.medium)) {
            const float length = found ? (v.si.p - origin).length() : kInfinity;
            if (!m->scatters()) {
                if (length > 0) met.absorption += m->thickness(origin, w, length);
            } else if (length > 0) {
                const float left = std::max(target - met.thickness[channel], 0.0f);
                if (const auto flight = m->fly(origin, w, length, channel, left)) {
                    met.thickness += flight->thickness;
                    placeInMedium(scene.mediumPoint(v.medium), origin + w * flight->distance, v.si);
                    v.inMedium = result.ends = true;
                    break;
                }
                met.thickness += m->thickness(origin, w, length);
            }
        }
        v.inMedium = false;
        if (!found) break;
        const NullLobe lobe = nullLobeAt(v.si, w);
        const bool passes =
            lobe.probability > 0 && crossings < kMostCrossings &&
            (lobe.probability >= 1 || !(target < met.thickness[channel] - std::log(lobe.probability)));
        if (!passes) {
            result.ends = true;
            break;
        }
        met.cross(v.si, lobe);
        v.medium = mediumBeyond(v.si, w, v.medium);
        origin = offsetRayOrigin(v.si.p, v.si.ng, w);
        found = scene.intersect({origin, w}, v.si);
    }
    const Passage passage = met.passage();
    result.forward = passage.arrival(result.ends ? v.stopDensity(-w) : Rgb(1.0f));
    result.reverse = passage.arrival(stop);
    result.dispersed = met.dispersed;
    if (result.forward > 0)
        result.weight = passage.transmittance * static_cast<float>(1 / result.forward);
    else
        result.forward = result.reverse = 1;  // rounded into emptiness: nothing comes of it
    return result;
}

}  // namespace metrolux::core
