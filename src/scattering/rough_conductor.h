#pragma once
#include "scattering/bsdf.h"
#include "scattering/microfacet.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A metal with microfacets (Mitsuba 3's `roughconductor`), on the side of the normal; the other side is
/// black. A texture that is null has the value given beside it.
struct RoughConductorParameters {
    TexturePtr eta;                  ///< real part of the index relative to the exterior; 0
    TexturePtr k;                    ///< imaginary part; 1
    TexturePtr specularReflectance;  ///< factor; 1
    TexturePtr alphaU, alphaV;       ///< roughness along tangent and bitangent; 0.1
    MicrofacetType distribution = MicrofacetType::Beckmann;
};
BsdfPtr makeRoughConductor(const RoughConductorParameters& parameters);

}  // namespace metrolux::core
