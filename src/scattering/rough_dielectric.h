#pragma once
#include "scattering/bsdf.h"
#include "scattering/microfacet.h"
#include "scattering/refractive_index.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A rough interface between two dielectrics (Mitsuba 3's `roughdielectric`); the normal points to the
/// exterior. A texture that is null has the value given beside it.
struct RoughDielectricParameters {
    RelativeIndex eta = 1.5046f / 1.000277f;  ///< bk7 in air
    TexturePtr specularReflectance;           ///< factor; 1
    TexturePtr specularTransmittance;         ///< factor; 1
    TexturePtr alphaU, alphaV;                ///< roughness along tangent and bitangent; 0.1
    MicrofacetType distribution = MicrofacetType::Beckmann;
};
/// Throws Error unless eta is positive, finite, and at no wavelength 1.
BsdfPtr makeRoughDielectric(const RoughDielectricParameters& parameters);

}  // namespace metrolux::core
