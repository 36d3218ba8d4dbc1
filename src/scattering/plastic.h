#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A diffuse base under a smooth dielectric coat (Mitsuba 3's `plastic`), on the side of the normal; the
/// other side is black. A texture that is null has the value given beside it.
struct PlasticParameters {
    float eta = 1.49f / 1.000277f;   ///< index of the coat over that of the exterior: polypropylene in air
    TexturePtr diffuseReflectance;   ///< of the base; 0.5
    TexturePtr specularReflectance;  ///< factor; 1
    bool nonlinear = false;          ///< colors saturate by scattering repeatedly below the coat
};
/// Throws Error unless eta is positive and finite.
BsdfPtr makePlastic(const PlasticParameters& parameters);

}  // namespace metrolux::core
