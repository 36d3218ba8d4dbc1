#pragma once
/// Multiple importance sampling weights of the five techniques of vertex connection and merging, by the
/// recursive quantities of [Geo12]: I. Georgiev, Implementing Vertex Connection and Merging, technical
/// report, Saarland University 2012 (abbreviated TR), with the technique counts of docs/explain/algorithm.md,
/// section 1.
///
/// Names of densities say who samples: FromLight is a density of the light subpath's side, FromEye one of the
/// eye subpath's. Per solid angle, unless the name says Area.
///
/// Roulette is left out of these densities: where it starts (rr_depth) counts edges from a subpath's own end,
/// so its probabilities are not a property of the path alone. Leaving it out costs nothing but optimality:
/// the weights depend on the path only and sum to one (docs/explain/notation.md).

#include "base/math.h"
#include "transport/strategies.h"

namespace metrolux::core {

/// How a light's densities turn into the measure of its first edge.
enum class EndpointKind : uint8_t { Surface, DeltaPosition, Infinite };

/// Densities around the first edge of a path, endpoint x0 on the light to surface point x1. Made by
/// transport/light_edge.h.
struct LightEdge {
    EndpointKind kind = EndpointKind::Surface;
    bool delta = false;        ///< the light cannot be hit
    double pdfNee = 1;         ///< of next-event estimation: per solid angle at x1, 1 for delta lights
    double pdfPosition = 1;    ///< of emission: per area (for an infinite light across its direction) ...
    double pdfDirection = 1;   ///< ... and per solid angle, with the choice of the light
    double cosineLight = 1;    ///< |cos| at x0, 1 where there is no surface
    double cosineSurface = 1;  ///< |cos| at x1 (geometric normal)
    double distanceSquared = 1;
    double arrival = 1;         ///< Passage::arrival() at x1, from x0
    double arrivalAtLight = 1;  ///< at x0, from x1

    double pdfEmission() const { return pdfPosition * pdfDirection; }
    /// Density of next-event estimation at x0, in the measure in which the eye subpath arrives there: per
    /// area, for an infinite light per solid angle.
    double pdfNeeAtLight() const {
        return kind == EndpointKind::Infinite ? pdfNee : pdfNee * cosineLight / distanceSquared;
    }
    /// p_trace(x0) p->(x1) / p_nee(x0), all densities per area (directions for infinite lights): the factors
    /// before the sums of TR eq. 31 and 45, for delta lights of eq. 48.
    double emissionOverNee() const {
        const double emitted = pdfEmission() * cosineSurface * arrival;
        switch (kind) {
            case EndpointKind::Surface:
                return emitted / (pdfNee * cosineLight);
            case EndpointKind::DeltaPosition:
                return emitted / (pdfNee * distanceSquared);
            case EndpointKind::Infinite:
                return emitted / pdfNee;
        }
        return 0;
    }
};

/// Partial sums of the weight at a vertex, of the techniques that join the subpaths there or before. dVCM is
/// one over the density of the vertex; at a subpath's first vertex it is multiplied by the count of the
/// technique that joins there (nee or splat), which connections do further on. The sum dVC of TR is kept in
/// two parts, because the factor of what eye subpaths find alone (Strategies::eyeFactor) is known only when
/// the path is complete. (TR's dVM is dVC over the count of merging.)
struct MisState {
    double dVCM = 0;
    double dEnd = 0;       ///< part of dVC: the techniques at the endpoint, nee and hit or splat
    double dInner = 0;     ///< part of dVC: connections and merges
    float mergeShare = 1;  ///< Strategies::mergeShare() at this vertex
    uint16_t region = 0;   ///< eye subpaths: PathClass::region
    uint8_t smooth = 0;    ///< vertices before this one that scattered by a smooth lobe, 255 at most
    bool first = true;     ///< the vertex after the endpoint

    /// The two parts of a sum over techniques.
    struct Sums {
        double end, inner;
        double total(double endFactor = 1) const { return endFactor * end + inner; }
    };
    /// The technique that joins the subpaths before this vertex.
    Sums joined(const Strategies& n) const { return first ? Sums{dVCM, 0} : Sums{0, n.connect * dVCM}; }
    /// All techniques that join the subpaths at this vertex (a merge) or before; pdfReverse is that of the
    /// direction to the predecessor, `share` of the merge.
    Sums sums(const Strategies& n, double pdfReverse, double share) const {
        const Sums before = joined(n);
        return {before.end + pdfReverse * dEnd, n.merge * share + before.inner + pdfReverse * dInner};
    }
    Sums sums(const Strategies& n, double pdfReverse) const { return sums(n, pdfReverse, mergeShare); }

    /// Eye subpath after its first ray; `pdfFromEye` per solid angle over the whole film, or per area on the
    /// film plane for a camera without position (orthographic): TR eq. 31-33.
    static MisState startEye(const Strategies& n, double pdfFromEye, uint16_t region = 0) {
        MisState s;
        s.dVCM = n.splat / pdfFromEye;
        s.region = region;
        return s;
    }

    /// Light subpath on arrival at its first surface point x1: TR eq. 31-33, for delta lights eq. 48-50.
    /// Takes the place of start and arrive, because the density of next-event estimation may depend on x1.
    static MisState arriveFromLight(const Strategies& n, const LightEdge& e) {
        MisState s;
        s.dVCM = n.nee / e.emissionOverNee();
        if (!e.delta) {
            const double cosine = e.kind == EndpointKind::Surface ? e.cosineLight : 1.0;
            s.dEnd = n.hit * cosine * e.arrivalAtLight / (e.pdfEmission() * e.cosineSurface * e.arrival);
        }
        return s;
    }

    /// Arrival at a surface: the density of the last direction becomes one per area. The second half of TR
    /// eq. 31-33 and 34-36.
    void arrive(double distanceSquared, double cosine) {
        dVCM *= distanceSquared / cosine;
        dEnd /= cosine;
        dInner /= cosine;
    }

    /// The edge of the arrival led through media: `forward` and `reverse` are factors of the densities of its
    /// far end and of its near end (Passage::arrival).
    void pass(double forward, double reverse) {
        dVCM /= forward;
        dEnd *= reverse / forward;
        dInner *= reverse / forward;
    }

    /// Scattering by a smooth lobe. `cosine` is that of the outgoing direction with the geometric normal;
    /// pdfForward of the outgoing direction, pdfReverse of the direction to the predecessor.
    void scatter(const Strategies& n, double cosine, double pdfForward, double pdfReverse) {
        const double g = cosine / pdfForward;
        const Sums s = sums(n, pdfReverse);  // TR eq. 35
        dEnd = g * s.end;
        dInner = g * s.inner;
        dVCM = 1.0 / pdfForward;  // TR eq. 34
        smooth += smooth < 255;
        first = false;
    }

    /// Scattering by a delta lobe: no technique joins subpaths here, TR eq. 53-55. The ratio of the two delta
    /// densities is the ratio of lobe probabilities times |d w_out / d w_in|: 1 at a reflection, at a
    /// refraction (eta_in^2 cos_in) / (eta_out^2 cos_out), with shading cosines because the law refers to
    /// them.
    void scatterDelta(double cosine, double probabilityRatio, double solidAngleRatio) {
        const double g = cosine * probabilityRatio * solidAngleRatio;
        dVCM = 0;
        dEnd *= g;
        dInner *= g;
        first = false;
    }
};

// Each weight is TR eq. 37, 1 / (light side + 1 + eye side), of a path that its technique makes, with the
// counts of hit and nee multiplied by the factor of the path's class. Where each path has one technique
// (photon mapping), all weights are one.

/// Weight of a path that an eye subpath has found, and the one it would have if hit and nee were all.
struct EyeWeight {
    double weight = 1;
    double alone = 1;
};

/// Of hitting a light with the eye subpath. pdfNee: LightEdge::pdfNeeAtLight(), `pdfEmission` of x0 and its
/// direction.
inline EyeWeight hitWeight(const Strategies& n, const MisState& eye, double pdfNee, double pdfEmission) {
    if (n.oneTechniqueForEachPath()) return {};
    const double factor = n.eyeFactor({eye.region, eye.smooth});
    const double nee = n.nee / n.hit * pdfNee * eye.dVCM;
    const double others = pdfEmission * (eye.dEnd + eye.dInner) / (n.hit * factor);
    return {1.0 / (1.0 + nee + others), 1.0 / (1.0 + nee)};  // TR eq. 43
}

/// Of next-event estimation. At the eye vertex: pdfFromEye of the direction toward the light, pdfFromLight of
/// that to the eye subpath's predecessor.
inline EyeWeight neeWeight(const Strategies& n, const MisState& eye, const LightEdge& e, double pdfFromEye,
                           double pdfFromLight) {
    const double factor = n.eyeFactor({eye.region, eye.smooth + 1});
    const double lightSide =
        e.delta ? 0.0 : n.hit / n.nee * pdfFromEye * e.arrivalAtLight / e.pdfNee;  // TR eq. 44
    const double eyeSide =
        e.emissionOverNee() / (n.nee * factor) * eye.sums(n, pdfFromLight).total();  // TR eq. 45
    return {1.0 / (1.0 + lightSide + eyeSide), 1.0 / (1.0 + lightSide)};
}

/// What hit and nee have of a path that a light subpath takes part in.
struct EyeRival {
    float share = 0;   ///< their weight
    float factor = 1;  ///< Strategies::eyeFactor() in it
};

/// Weight of a path that a light subpath takes part in.
struct LightWeight {
    double weight = 1;
    EyeRival eye;

    static LightWeight of(double weight, double eyeShare, double factor) {
        return {weight, {static_cast<float>(eyeShare), static_cast<float>(factor)}};
    }
};

/// Of connecting a light vertex to the camera, in a region of the film. pdfAreaFromEye: of the vertex,
/// sampled by the camera; pdfFromEye: of the direction to the light subpath's predecessor.
inline LightWeight splatWeight(const Strategies& n, const MisState& light, uint16_t region,
                               double pdfAreaFromEye, double pdfFromEye, bool inMedium = false) {
    const double factor = n.eyeFactor({region, light.smooth + 1});
    const double scale = pdfAreaFromEye / n.splat;
    const MisState::Sums s = light.sums(n, pdfFromEye, n.certainMergeShare(inMedium));
    const double weight = 1.0 / (1.0 + scale * s.total(factor));  // TR eq. 46
    return LightWeight::of(weight, weight * scale * factor * s.end, factor);
}

/// Of connecting two inner vertices. pdfAreaFromEye: of the light vertex, sampled by the eye vertex, and
/// pdfReverseFromEye then of the direction to the light subpath's predecessor; FromLight the converse.
inline LightWeight connectWeight(const Strategies& n, const MisState& light, const MisState& eye,
                                 double pdfAreaFromEye, double pdfAreaFromLight, double pdfReverseFromEye,
                                 double pdfReverseFromLight) {
    const double factor = n.eyeFactor({eye.region, light.smooth + eye.smooth + 2});
    const MisState::Sums s = light.sums(n, pdfReverseFromEye);
    const double lightSide = pdfAreaFromEye * s.total(factor);                           // TR eq. 40
    const double eyeSide = pdfAreaFromLight * eye.sums(n, pdfReverseFromLight).total();  // TR eq. 41
    const double all = n.connect + lightSide + eyeSide;
    return LightWeight::of(n.connect / all, pdfAreaFromEye * factor * s.end / all, factor);
}

/// Of merging. At the eye vertex: pdfFromEye of the direction to the light subpath's predecessor,
/// pdfFromLight of that to the eye subpath's.
inline LightWeight mergeWeight(const Strategies& n, const MisState& light, const MisState& eye,
                               double pdfFromEye, double pdfFromLight) {
    if (n.oneTechniqueForEachPath()) return {};
    const double factor = n.eyeFactor({eye.region, light.smooth + eye.smooth + 1});
    const MisState::Sums s = light.sums(n, pdfFromEye, 0);
    const double lightSide = s.total(factor) / n.merge;                     // TR eq. 38
    const double eyeSide = eye.sums(n, pdfFromLight, 0).total() / n.merge;  // TR eq. 39
    const double all = eye.mergeShare + lightSide + eyeSide;
    return LightWeight::of(eye.mergeShare / all, factor * s.end / n.merge / all, factor);
}

}  // namespace metrolux::core
