#pragma once
#include "geometry/shape.h"
#include "media/medium.h"

namespace metrolux::core {

/// What a vertex in a medium has in place of a shape: its "BSDF" scatters by the phase function. The
/// scattering value S is then sigma_s times the phase function, per unit of length, with no cosine, in the
/// frame of the world; its stopDensity() is the extinction.
ShapePtr makeMediumPoint(MediumPtr medium);

/// Fills `si` with a point of it.
inline void placeInMedium(const Shape& mediumPoint, const Vec3f& p, SurfaceInteraction& si) {
    const float wavelength = si.wavelength;
    si = {};
    si.wavelength = wavelength;
    si.p = p;
    si.s = Vec3f(1, 0, 0);
    si.ns = Vec3f(0, 0, 1);  // ng stays zero: there is no surface to move off, and no side
    si.shape = &mediumPoint;
}

}  // namespace metrolux::core
