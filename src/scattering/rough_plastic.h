#pragma once
#include "scattering/bsdf.h"
#include "scattering/microfacet.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A diffuse base under a rough dielectric coat (Mitsuba 3's `roughplastic`), on the side of the normal; the
/// other side is black. A texture that is null has the value given beside it.
struct RoughPlasticParameters {
    float eta = 1.49f / 1.000277f;   ///< index of the coat over that of the exterior: polypropylene in air
    TexturePtr diffuseReflectance;   ///< of the base; 0.5
    TexturePtr specularReflectance;  ///< factor; 1
    bool nonlinear = false;          ///< colors saturate by scattering repeatedly below the coat
    float alpha = 0.1f;              ///< roughness, isotropic
    TexturePtr alphaTexture;         ///< in its place, where there is one
    MicrofacetType distribution = MicrofacetType::Beckmann;
};
/// Throws Error unless eta is positive, finite and not 1.
BsdfPtr makeRoughPlastic(const RoughPlasticParameters& parameters);

}  // namespace metrolux::core
