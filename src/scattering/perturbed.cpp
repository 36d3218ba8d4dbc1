#include "scattering/perturbed.h"

namespace metrolux::core {
namespace {

Vec3f tiltedToOtherSide(const Vec3f& n) { return {-n.x, -n.y, n.z}; }

/// The frame of a tilted normal, its tangent as near as possible to the original one.
Frame tiltedFrame(const Vec3f& n) { return Frame::fromNormalAndTangent(n, Vec3f(1, 0, 0)); }

/// A direction counts when it is on the same side of both frames.
bool isConsistent(const Vec3f& n, const Vec3f& v) { return v.z * dot(n, v) > 0; }

/// What the nested model sees: the same point with the tilted shading frame.
SurfaceInteraction tilted(const SurfaceInteraction& si, const Frame& frame) {
    SurfaceInteraction result = si;
    result.ns = si.toWorld(frame.n);
    result.s = si.toWorld(frame.s);
    return result;
}

float tan2Theta(const Vec3f& v) { return sin2Theta(v) / std::max(cos2Theta(v), 1e-12f); }

float shadowing(const Vec3f& n, const Vec3f& wLight) {
    const float alpha2 = std::min(0.125f * tan2Theta(n), 1.0f);
    return 2.0f / (1.0f + std::sqrt(1.0f + alpha2 * tan2Theta(wLight)));
}

}  // namespace

Vec3f PerturbedBsdf::unitNormal(const SurfaceInteraction& si) const {
    const Vec3f n = normal(si);
    const float length2 = lengthSquared(n);
    if (!(length2 > 0) || !std::isfinite(length2)) return {0, 0, 1};
    return n * (1.0f / std::sqrt(length2));
}

bool PerturbedBsdf::isFlipped(const Vec3f& n, const Vec3f& wEye) const {
    return options_.flipInvalidNormals && !isConsistent(n, wEye);
}

/// Probability with which a light subpath tries the normal that is tilted to the other side. The eye
/// directions that need it fill a sliver above the horizon as wide as the tilt; the square root of the energy
/// there is proportional to the tilt, and that is the best share.
float PerturbedBsdf::flippedProbability(const Vec3f& n, const Vec3f& wLight) const {
    if (!options_.flipInvalidNormals) return 0;
    if (!isConsistent(n, wLight)) return 1;
    if (!isConsistent(tiltedToOtherSide(n), wLight)) return 0;
    return 0.5f * safeSqrt(sin2Theta(n));
}

std::optional<BsdfSample> PerturbedBsdf::sample(const SurfaceInteraction& si, const Vec3f& known,
                                                TransportMode mode, float uLobe, const Vec2f& u) const {
    const bool radiance = mode == TransportMode::Radiance;
    const Vec3f unflipped = unitNormal(si);
    bool flipped;
    float probability = 1;  // of the frame, given what the subpath knows
    if (radiance) {
        flipped = isFlipped(unflipped, known);
    } else {
        const float p = flippedProbability(unflipped, known);
        flipped = uLobe < p;
        probability = flipped ? p : 1 - p;
        uLobe = std::min(flipped ? uLobe / p : (uLobe - p) / (1 - p), kOneMinusEpsilon);
    }
    const Vec3f n = flipped ? tiltedToOtherSide(unflipped) : unflipped;
    if (!isConsistent(n, known)) return std::nullopt;
    const Frame frame = tiltedFrame(n);
    auto result = nested_->sample(tilted(si, frame), frame.toLocal(known), mode, uLobe, u);
    if (!result) return std::nullopt;
    const Vec3f direction = frame.toWorld(result->direction);
    if (!isConsistent(n, direction)) return std::nullopt;
    const Vec3f& wEye = radiance ? known : direction;
    const Vec3f& wLight = radiance ? direction : known;
    if (isFlipped(unflipped, wEye) != flipped) return std::nullopt;
    if (!result->delta) return finishSmooth(si, known, direction, mode, result->eta);

    const float otherProbability = radiance ? flippedProbability(unflipped, wLight) : 0.0f;
    const float reverse = !radiance ? 1.0f : flipped ? otherProbability : 1 - otherProbability;
    result->direction = direction;
    result->pdfForward *= probability;
    result->pdfReverse *= reverse;
    result->weight *= (options_.useShadowing ? shadowing(n, wLight) : 1.0f) / probability;
    return result;
}

BsdfEvaluation PerturbedBsdf::evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                                       const Vec3f& wLight) const {
    const Vec3f unflipped = unitNormal(si);
    const bool flipped = isFlipped(unflipped, wEye);
    const Vec3f n = flipped ? tiltedToOtherSide(unflipped) : unflipped;
    if (!isConsistent(n, wEye) || !isConsistent(n, wLight)) return {};
    const Frame frame = tiltedFrame(n);
    BsdfEvaluation e = nested_->evaluate(tilted(si, frame), frame.toLocal(wEye), frame.toLocal(wLight));
    if (options_.useShadowing) e.value *= shadowing(n, wLight);
    const float p = flippedProbability(unflipped, wLight);
    e.pdfEye *= flipped ? p : 1 - p;
    return e;
}

}  // namespace metrolux::core
