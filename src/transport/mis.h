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

    double pdfEmission() const { return pdfPosition * pdfDirection; }
    /// Density of next-event estimation at x0, in the measure in which the eye subpath arrives there: per
    /// area, for an infinite light per solid angle.
    double pdfNeeAtLight() const {
        return kind == EndpointKind::Infinite ? pdfNee : pdfNee * cosineLight / distanceSquared;
    }
    /// p_trace(x0) p->(x1) / p_nee(x0), all densities per area (directions for infinite lights): the factors
    /// before the sums of TR eq. 31 and 45, for delta lights of eq. 48.
    double emissionOverNee() const {
        const double emitted = pdfEmission() * cosineSurface;
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
/// technique that joins there (nee or splat), which connections do further on.
struct MisState {
    double dVCM = 0, dVC = 0, dVM = 0;
    float mergeShare = 1;  ///< Strategies::mergeShare() at this vertex
    bool first = true;     ///< the vertex after the endpoint

    /// The term of the technique that joins the subpaths before this vertex.
    double joined(const Strategies& n) const { return first ? dVCM : n.connect * dVCM; }

    /// Eye subpath after its first ray; `pdfFromEye` per solid angle over the whole film, or per area on the
    /// film plane for a camera without position (orthographic): TR eq. 31-33.
    static MisState startEye(const Strategies& n, double pdfFromEye) { return {n.splat / pdfFromEye, 0, 0}; }

    /// Light subpath on arrival at its first surface point x1: TR eq. 31-33, for delta lights eq. 48-50.
    /// Takes the place of start and arrive, because the density of next-event estimation may depend on x1.
    static MisState arriveFromLight(const Strategies& n, const LightEdge& e) {
        MisState s;
        s.dVCM = n.nee / e.emissionOverNee();
        if (!e.delta) {
            const double cosine = e.kind == EndpointKind::Surface ? e.cosineLight : 1.0;
            s.dVC = n.hit * cosine / (e.pdfEmission() * e.cosineSurface);
            s.dVM = n.merge > 0 ? s.dVC / n.merge : 0;
        }
        return s;
    }

    /// Arrival at a surface: the density of the last direction becomes one per area. The second half of TR
    /// eq. 31-33 and 34-36.
    void arrive(double distanceSquared, double cosine) {
        dVCM *= distanceSquared / cosine;
        dVC /= cosine;
        dVM /= cosine;
    }

    /// Scattering by a smooth lobe. `cosine` is that of the outgoing direction with the geometric normal;
    /// pdfForward of the outgoing direction, pdfReverse of the direction to the predecessor.
    void scatter(const Strategies& n, double cosine, double pdfForward, double pdfReverse) {
        const double g = cosine / pdfForward, before = joined(n);
        dVC = g * (n.merge * mergeShare + before + pdfReverse * dVC);                    // TR eq. 35
        dVM = n.merge > 0 ? g * (mergeShare + before / n.merge + pdfReverse * dVM) : 0;  // TR eq. 36
        dVCM = 1.0 / pdfForward;                                                         // TR eq. 34
        first = false;
    }

    /// Scattering by a delta lobe: no technique joins subpaths here, TR eq. 53-55. The ratio of the two delta
    /// densities is the ratio of lobe probabilities times |d w_out / d w_in|: 1 at a reflection, at a
    /// refraction (eta_in^2 cos_in) / (eta_out^2 cos_out), with shading cosines because the law refers to
    /// them.
    void scatterDelta(double cosine, double probabilityRatio, double solidAngleRatio) {
        const double g = cosine * probabilityRatio * solidAngleRatio;
        dVCM = 0;
        dVC *= g;
        dVM *= g;
        first = false;
    }
};

// Each weight is TR eq. 37, 1 / (light side + 1 + eye side), of a path that its technique makes. Where each
// path has one technique (photon mapping), all weights are one.

/// Of hitting a light with the eye subpath. pdfNee: LightEdge::pdfNeeAtLight(), `pdfEmission` of x0 and its
/// direction.
inline double hitWeight(const Strategies& n, const MisState& eye, double pdfNee, double pdfEmission) {
    if (n.oneTechniqueForEachPath()) return 1;
    return 1.0 / (1.0 + n.nee / n.hit * pdfNee * eye.dVCM + pdfEmission * eye.dVC / n.hit);  // TR eq. 43
}

/// Of next-event estimation. At the eye vertex: pdfFromEye of the direction toward the light, pdfFromLight of
/// that to the eye subpath's predecessor.
inline double neeWeight(const Strategies& n, const MisState& eye, const LightEdge& e, double pdfFromEye,
                        double pdfFromLight) {
    const double lightSide = e.delta ? 0.0 : n.hit / n.nee * pdfFromEye / e.pdfNee;  // TR eq. 44
    const double eyeSide = e.emissionOverNee() / n.nee *
                           (n.merge * eye.mergeShare + eye.joined(n) + pdfFromLight * eye.dVC);  // TR eq. 45
    return 1.0 / (1.0 + lightSide + eyeSide);
}

/// Of connecting a light vertex to the camera. pdfAreaFromEye: of the vertex, sampled by the camera;
/// pdfFromEye: of the direction to the light subpath's predecessor.
inline double splatWeight(const Strategies& n, const MisState& light, double pdfAreaFromEye,
                          double pdfFromEye) {
    return 1.0 / (1.0 + pdfAreaFromEye / n.splat *
                            (n.merge + light.joined(n) + pdfFromEye * light.dVC));  // TR eq. 46
}

/// Of connecting two inner vertices. pdfAreaFromEye: of the light vertex, sampled by the eye vertex, and
/// pdfReverseFromEye then of the direction to the light subpath's predecessor; FromLight the converse.
inline double connectWeight(const Strategies& n, const MisState& light, const MisState& eye,
                            double pdfAreaFromEye, double pdfAreaFromLight, double pdfReverseFromEye,
                            double pdfReverseFromLight) {
    const double lightSide = pdfAreaFromEye * (n.merge * light.mergeShare + light.joined(n) +
                                               pdfReverseFromEye * light.dVC);  // TR eq. 40
    const double eyeSide = pdfAreaFromLight * (n.merge * eye.mergeShare + eye.joined(n) +
                                               pdfReverseFromLight * eye.dVC);  // TR eq. 41
    return n.connect / (n.connect + lightSide + eyeSide);
}

/// Of merging. At the eye vertex: pdfFromEye of the direction to the light subpath's predecessor,
/// pdfFromLight of that to the eye subpath's.
inline double mergeWeight(const Strategies& n, const MisState& light, const MisState& eye, double pdfFromEye,
                          double pdfFromLight) {
    if (n.oneTechniqueForEachPath()) return 1;
    const double lightSide = light.joined(n) / n.merge + pdfFromEye * light.dVM;  // TR eq. 38
    const double eyeSide = eye.joined(n) / n.merge + pdfFromLight * eye.dVM;      // TR eq. 39
    return eye.mergeShare / (eye.mergeShare + lightSide + eyeSide);
}

}  // namespace metrolux::core
