#pragma once
#include "image/film.h"
#include "integrators/photon_map.h"
#include "transport/technique.h"

namespace metrolux::core {

/// What a point of the primary sample space of complete paths contributes: one eye subpath and one light
/// subpath are traced and joined by the techniques of bidirectional path tracing, with their weights. The
/// integrand of PSSMLT [Kel02] and of multiplexed MLT (Hachisuka, Kaplanyan, Dachsbacher 2014).
///
/// Emitters that the camera sees directly (paths of one edge) are left out: they need no search.
///
/// Scale: each splat is an estimate of the film's density at its raster position from one sample; average
/// over samples (SplatList, Film::addSplats).
struct PathPair {
    const Scene& scene;
    const PathLimits& limits;
    const Strategies& strategies;
    const Film& film;                    ///< of which the window and the filter matter
    NonFiniteCounts& nonFinite;          ///< counts what is left out
    const PhotonMap* photons = nullptr;  ///< all() merges the eye subpath with them, if given

    // Where the scene has dispersion and the strategies have no wavelength, each path has its own, a
    // coordinate of its sample.

    /// All techniques of all path lengths; `splats` is cleared first.
    void all(SampleStream& u, SplatList& splats) const;
    /// One technique of paths of `length` >= 2 edges, chosen uniformly by layout::kTechnique (the inverse of
    /// its probability is part of the value); `splats` is cleared first.
    void one(int length, SampleStream& u, SplatList& splats) const;

  private:
    /// With the wavelength of a sample.
    Strategies strategiesOf(SampleStream& eye) const;
    /// Splats outside of Film::reach() change no pixel and may not count for the size either.
    void addSplat(const Vec2f& raster, const Rgb& value, Technique technique, SplatList& splats) const;
};

}  // namespace metrolux::core
