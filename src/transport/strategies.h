#pragma once
#include "base/math.h"
#include "scattering/wavelength.h"
#include "spatial/photon_density.h"
#include "transport/eye_factors.h"

#include <algorithm>

namespace metrolux::core {

/// Number of samples of each technique in an iteration, relative to connections, 0 = off
/// (docs/explain/algorithm.md, section 1). The passes do what has a count, the weights take it into account:
/// nothing else says which techniques run.
struct Strategies {
    double hit = 0;  ///< the eye subpath ends on an emitter: 1 / lambda
    double nee = 0;  ///< eye vertex connected to a fresh light point: 1 / lambda
    /// Connections of inner vertices: share of the light subpaths that are connected with an eye subpath.
    double connect = 0;
    /// Light vertices connected to the camera, which needs no eye subpath: less than 1 where eye subpaths are
    /// sampled more densely than evenly (split_mcmc).
    double splat = 0;
    double merge = 0;  ///< eta = N pi r^2
    /// Of merging in media, N 4/3 pi r^3 with a radius of its own, over `merge`; 0: off.
    double mergeInMedia = 0;
    /// Photon mapping: an eye subpath ends at its first vertex that can merge, and merging is the technique
    /// of all paths that have one; hit is that of the others. Else it merges at every vertex.
    enum class MergeAt : uint8_t { EveryVertex, FirstVertex } mergeAt = MergeAt::EveryVertex;
    /// Density of the light subpaths' vertices, for mergeShare(); null: every merge counts in full.
    const PhotonDensity* photons = nullptr;
    /// Of what eye subpaths find alone; null: 1.
    const EyeFactors* eyeFactors = nullptr;

    /// Of all paths; not given in scenes without dispersion.
    Wavelength wavelength = {};

    /// What is seen of a value that has come by a path with dispersion (Vertex::dispersed) or without.
    Rgb seen(const Rgb& value, bool dispersed) const { return dispersed ? value * wavelength.color : value; }

    /// Factor of `hit` and `nee` for the paths of a class.
    double eyeFactor(const PathClass& c) const { return eyeFactors ? eyeFactors->at(c) : 1.0; }
    /// Region of a path that goes through this point of the film.
    uint16_t regionOf(const Vec2f& raster) const { return eyeFactors ? eyeFactors->regionOf(raster) : 0; }
    /// Of a pixel, an index in the window.
    uint16_t regionOf(uint32_t pixel) const { return eyeFactors ? eyeFactors->regionOf(pixel) : 0; }

    bool oneTechniqueForEachPath() const { return mergeAt == MergeAt::FirstVertex; }
    /// Whether the light subpaths need the eye subpaths' vertices.
    bool joinsSubpaths() const { return connect > 0 || merge > 0; }

    /// Share c of `merge` that counts at a vertex which the eye subpath has reached by chance. All photons
    /// within the radius share that vertex: their mean is an estimate from one eye subpath, however many they
    /// are, so that K expected photons count as max(1, K) / K. (After Grittmann et al. 2021,
    /// Correlation-Aware MIS for Bidirectional Rendering Algorithms, whose heuristic compares densities of
    /// the path; here K is measured.) The eye subpath's first smooth vertex is not chance: there c = 1.
    double mergeShare(const Vec3f& p) const {
        if (!photons || !(merge > 0)) return 1;
        return 1 / std::max(1.0, merge / std::max(hit, nee) * double(photons->roughlyAt(p)));
    }

    /// At a vertex that is not there by chance.
    double certainMergeShare(bool inMedium) const { return inMedium ? mergeInMedia : 1.0; }

    static Strategies path() { return {.hit = 1, .nee = 1}; }
    /// Eye subpaths that find lights by hitting them only.
    static Strategies hitsAlone() { return {.hit = 1}; }
    /// Light subpaths that are connected to the camera only.
    static Strategies splatsAlone() { return {.splat = 1}; }
    static Strategies photonMapping() {
        return {.hit = 1, .merge = 1, .mergeInMedia = 1, .mergeAt = MergeAt::FirstVertex};
    }
    /// All five: lambda is the number of light subpaths (with the density boost of chains) for each eye
    /// subpath; eta = 0 leaves merging out.
    static Strategies bidirectional(double lambda, double eta, const PhotonDensity* photons = nullptr,
                                    double splat = 1) {
        return {.hit = 1.0 / lambda,
                .nee = 1.0 / lambda,
                .connect = 1,
                .splat = splat,
                .merge = eta,
                .photons = photons};
    }
};

}  // namespace metrolux::core
