#pragma once
/// Multiple importance sampling weights of the five techniques of vertex connection and merging, by the
/// recursive quantities of [Geo12]: I. Georgiev, Implementing Vertex Connection and Merging, technical
/// report, Saarland University 2012 (abbreviated TR), with the technique counts of docs/explain/algorithm.md
/// section 1.
///
/// Roulette is left out of these densities: where it starts (rr_depth) counts edges from a subpath's own end,
/// so its probabilities are not a property of the path alone. Leaving it out costs nothing but optimality:
/// the weights depend on the path only and sum to one (docs/explain/notation.md).

#include "base/math.h"
#include "transport/photon_density.h"

#include <algorithm>

namespace metrolux::core {

/// Number of samples of each technique in an iteration, relative to connections: it feeds MIS and is never a
/// behavior switch. `merge` is eta = N pi r^2; `hitNee` is 1 / lambda.
struct Strategies {
    double hitNee = 1;
    /// Connections of inner vertices: share of the light subpaths that are connected with an eye subpath. 0
    /// for path tracing.
    double connect = 1;
    double merge = 0;
    /// Density of the light subpaths' vertices, for mergeShare(); null: every merge counts in full.
    const PhotonDensity* photons = nullptr;
    /// Connections of light vertices to the camera, which need no eye subpath: less than connections where
    /// eye subpaths are sampled more densely than evenly (split_mcmc). 0 for path tracing.
    double splat = 1;
    /// Next-event estimations for each hit: 1, or 0 where there are none (photon mapping; no other weight
    /// than that of hit knows of this).
    double nee = 1;

    /// Share c of `merge` that counts at a vertex which the eye subpath has reached by chance. All photons
    /// within the radius share that vertex: their mean is an estimate from one eye subpath, however many they
    /// are, so that K expected photons count as max(1, K) / K. (After Grittmann et al. 2021,
    /// Correlation-Aware MIS for Bidirectional Rendering Algorithms, whose heuristic compares densities of
    /// the path; here K is measured.) The eye subpath's first smooth vertex is not chance: there c = 1.
    double mergeShare(const Vec3f& p) const {
        if (!photons || !(merge > 0)) return 1;
        return 1 / std::max(1.0, merge / hitNee * double(photons->roughlyAt(p)));
    }

    /// Asks for the memory that mergeShare(p) will read.
    void prefetchMergeShare(const Vec3f& p) const {
        if (photons) photons->prefetch(p);
    }

    /// Samples of a technique of a subpath's ends for each connection: dVCM counts in these, as everywhere
    /// but at the ends it stands for connections. (Where there are none it stands for nothing.)
    double perConnection(double samples) const { return connect > 0 ? samples / connect : samples; }

    static Strategies path() { return {1, 0, 0, nullptr, 0}; }
    /// Eye subpaths that find lights by hitting them only.
    static Strategies hitsAlone() { return {1, 0, 0, nullptr, 0, 0}; }
    static Strategies bidirectional(double lambda, double eta, const PhotonDensity* photons = nullptr,
                                    double splat = 1) {
        return {1.0 / lambda, 1, eta, photons, splat};
    }
};

/// How a light's densities turn into the measure of its first edge.
enum class EndpointKind : uint8_t { Surface, DeltaPosition, Infinite };

/// Densities around the first edge of a light subpath, endpoint x0 to surface point x1.
struct LightEdge {
    EndpointKind kind = EndpointKind::Surface;
    bool delta = false;      ///< the light cannot be hit
    double connect = 1;      ///< density of next-event estimation: per solid angle at x1, 1 for delta lights
    double position = 1;     ///< density of emission: per area ...
    double direction = 1;    ///< ... and per solid angle
    double cosineLight = 1;  ///< |cos| at x0
    double cosineSurface = 1;  ///< |cos| at x1 (geometric normal)
    double distanceSquared = 1;

    /// (p_trace(x0) p->(x1)) / p_nee(x0), all densities per area (directions for infinite lights): TR eq.
    /// 36, 44.
    double emissionOverConnection() const {
        const double emitted = position * direction * cosineSurface;
        switch (kind) {
            case EndpointKind::Surface:
                return emitted / (connect * cosineLight);
            case EndpointKind::DeltaPosition:
                return emitted / (connect * distanceSquared);
            case EndpointKind::Infinite:
                return emitted / connect;
        }
        return 0;
    }
};

/// Partial sums of the weight, TR eq. 31-36 (dVCM, dVC, dVM at the current vertex).
struct MisState {
    double dVCM = 0, dVC = 0, dVM = 0;

    /// Eye subpath after its first ray; `pdfDirection` per solid angle over the whole film.
    static MisState startEye(const Strategies& n, double pdfDirection) {
        return {n.perConnection(n.splat) / pdfDirection, 0, 0};
    }

    /// Eye subpath of a camera without position (orthographic): density per area on the film plane.
    static MisState startEyeInfinite(const Strategies& n, double pdfPosition) {
        return {n.perConnection(n.splat) / pdfPosition, 0, 0};
    }

    /// Light subpath on arrival at its first surface point x1: TR eq. 34-36 with the counts of nee and hit.
    /// Takes the place of start and arrive, because the density of next-event estimation may depend on x1.
    static MisState arriveFromLight(const Strategies& n, const LightEdge& e, double emissionOverConnection) {
        MisState s;
        s.dVCM = n.perConnection(n.hitNee) / emissionOverConnection;
        if (!e.delta) {
            const double cosine = e.kind == EndpointKind::Surface ? e.cosineLight : 1.0;
            s.dVC = n.hitNee * cosine / (e.position * e.direction * e.cosineSurface);
            s.dVM = n.merge > 0 ? s.dVC / n.merge : 0;
        }
        return s;
    }

    /// Arrival at a surface: the density of the last direction becomes one per area (TR eq. 31).
    void arrive(double distanceSquared, double cosine) {
        dVCM *= distanceSquared / cosine;
        dVC /= cosine;
        dVM /= cosine;
    }

    /// Scattering by a smooth lobe: TR eq. 31-33. `cosine` is that of the outgoing direction with the
    /// geometric normal; densities per solid angle; `share`: of merging at this vertex.
    void scatter(const Strategies& n, double cosine, double pdfForward, double pdfReverse, double share = 1) {
        const double g = cosine / pdfForward;
        const double previous = n.connect * dVCM;
        dVC = g * (n.merge * share + previous + pdfReverse * dVC);
        dVM = n.merge > 0 ? g * (share + previous / n.merge + pdfReverse * dVM) : 0;
        dVCM = 1.0 / pdfForward;
    }

    /// Scattering by a delta lobe: no technique joins subpaths here (TR section 4.3). The ratio of the two
    /// delta densities is the ratio of lobe probabilities times |d w_out / d w_in|: 1 at a reflection, at a
    /// refraction (eta_in^2 cos_in) / (eta_out^2 cos_out), with shading cosines because the law refers to
    /// them.
    void scatterDelta(double cosine, double probabilityRatio, double solidAngleRatio) {
        const double g = cosine * probabilityRatio * solidAngleRatio;
        dVCM = 0;
        dVC *= g;
        dVM *= g;
    }
};

/// Weight of hitting a light with the eye subpath: TR eq. 43. `connectArea`: density of next-event estimation
/// for the hit point per area (per solid angle for an environment); `emission`: position * direction density.
inline double hitWeight(const Strategies& n, const MisState& eye, double connectArea, double emission) {
    return 1.0 / (1.0 + n.nee * connectArea * eye.dVCM + emission * eye.dVC / n.hitNee);
}

/// Weight of next-event estimation: TR eq. 44. Densities per solid angle at the eye vertex; `share` of
/// merging there.
inline double neeWeight(const Strategies& n, const MisState& eye, const LightEdge& e, double pdfLight,
                        double pdfEye, double share = 1) {
    const double light = e.delta ? 0.0 : pdfLight / e.connect;
    const double eyeSide =
        e.emissionOverConnection() / n.hitNee * (n.merge * share + n.connect * eye.dVCM + pdfEye * eye.dVC);
    return 1.0 / (1.0 + light + eyeSide);
}

/// Weight of connecting a light vertex to the camera: TR eq. 46. `cameraArea`: density per area with which
/// the camera samples the vertex; `pdfLight`: reverse density at the vertex.
inline double splatWeight(const Strategies& n, const MisState& light, double cameraArea, double pdfLight) {
    return 1.0 / (1.0 + cameraArea / n.splat * (n.merge + n.connect * light.dVCM + pdfLight * light.dVC));
}

/// Weight of connecting two inner vertices: TR eq. 40-42. `lightArea`: density per area with which the eye
/// vertex samples the light vertex, `eyeArea` the converse; pdfLight: reverse density at the light vertex,
/// pdfEye at the eye's. Shares of merging at either.
inline double connectWeight(const Strategies& n, const MisState& light, const MisState& eye, double lightArea,
                            double eyeArea, double pdfLight, double pdfEye, double lightShare = 1,
                            double eyeShare = 1) {
    const double lightSide =
        lightArea * (n.merge * lightShare + n.connect * light.dVCM + pdfLight * light.dVC);
    const double eyeSide = eyeArea * (n.merge * eyeShare + n.connect * eye.dVCM + pdfEye * eye.dVC);
    return n.connect / (n.connect + lightSide + eyeSide);
}

/// Weight of merging: TR eq. 37-39. At the eye vertex, `pdfLight` is the density of the direction toward the
/// light subpath's predecessor given the eye's, `pdfEye` the converse, `share` that of merging.
inline double mergeWeight(const Strategies& n, const MisState& light, const MisState& eye, double pdfLight,
                          double pdfEye, double share = 1) {
    const double lightSide = n.connect * light.dVCM / n.merge + pdfLight * light.dVM;
    const double eyeSide = n.connect * eye.dVCM / n.merge + pdfEye * eye.dVM;
    return share / (share + lightSide + eyeSide);
}

}  // namespace metrolux::core
