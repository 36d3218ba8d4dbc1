#pragma once
/// Edges of paths in scenes with media: what happens between two vertices. Surfaces whose null lobe lets
/// light straight on and boundaries of media are crossed without a vertex; a walk may end in a medium on the
/// way (docs/explain/media.md).

#include "scene/scene.h"
#include "transport/vertex.h"

namespace metrolux::core {

/// What lies beyond `v` in direction w (unit, world).
inline MediumIndex mediumBeyond(const Vertex& v, const Vec3f& w) { return mediumBeyond(v.si, w, v.medium); }

/// From one point to another.
struct Passage {
    /// Share of the light that gets through; black where a surface is in the way.
    Rgb transmittance{1.0f};
    /// Probability that a walk gets as far, for the channel that it has chosen to be led by. Not the
    /// transmittance: media that only absorb do not stop a walk, and null lobes may be colored.
    Rgb survival{1.0f};
    bool dispersed = false;  ///< it has crossed a surface with dispersion

    bool blocked() const { return isBlack(transmittance); }
    /// Density of the vertex at the end, from that of its direction: the mean over the channels. `stop`: its
    /// stopDensity(); 1 for a surface and an endpoint.
    double arrival(const Rgb& stop = Rgb(1.0f)) const { return double(average(survival * stop)); }
};

/// Along a ray of finite or infinite length, for light of a wavelength (SurfaceInteraction::wavelength).
Passage passAlong(const Scene& scene, const Ray& ray, MediumIndex medium, float wavelength = 0);

/// How an edge of a walk goes on and ends.
struct WalkPassage {
    bool ends = false;       ///< at a vertex; else it leaves the scene
    Rgb weight{0.0f};        ///< of the throughput: transmittance over density
    double forward = 1;      ///< Passage::arrival() at its end
    double reverse = 1;      ///< at its start, for a walk from its end
    bool dispersed = false;  ///< Passage::dispersed
};

/// Follows a walk along `ray`, which starts in v.medium. `found`: whether it meets a surface at v.si. Sets
/// v.si, v.medium and v.inMedium to where it ends. `u` chooses the channel and the distance; `stop`:
/// stopDensity() of the vertex at its start.
WalkPassage walkAlong(const Scene& scene, const Ray& ray, const Rgb& stop, float u, bool found, Vertex& v);

}  // namespace metrolux::core
