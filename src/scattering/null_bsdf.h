#pragma once
#include "scattering/bsdf.h"

namespace metrolux::core {

/// The surface that is not there: everything passes straight on.
BsdfPtr makeNullBsdf();
bool isNullBsdf(const Bsdf& bsdf);

/// The delta lobe that lets `energy` pass straight on, chosen with `probability` from either end.
BsdfSample passThrough(const Vec3f& known, const Rgb& energy, float probability);

}  // namespace metrolux::core
