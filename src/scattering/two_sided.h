#pragma once
#include "scattering/bsdf.h"

namespace metrolux::core {

/// An opaque model for each side of the surface; the back is seen in the frame mirrored at the surface.
struct TwoSidedParameters {
    BsdfPtr front;
    BsdfPtr back;  ///< the front's when null
};
/// Throws Error when a nested model is transmissive.
BsdfPtr makeTwoSided(const TwoSidedParameters& parameters);

}  // namespace metrolux::core
