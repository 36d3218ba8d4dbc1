#pragma once
#include "scattering/bsdf.h"
#include "scattering/refractive_index.h"
#include "scattering/texture.h"

#include <optional>

namespace metrolux::core {

/// Mitsuba 3's `principled`: metal, dielectric with diffuse base, rough glass, sheen and clear coat in one
/// model. The normal points to the exterior; the inside scatters only where spec_trans > 0. A texture that is
/// null has the value given beside it.
struct PrincipledParameters {
    TexturePtr baseColor;              ///< 0.5
    TexturePtr roughness;              ///< 0.5
    TexturePtr anisotropic;            ///< 0
    TexturePtr metallic;               ///< 0
    TexturePtr specTrans;              ///< 0
    TexturePtr specTint;               ///< 0
    TexturePtr sheen;                  ///< 0
    TexturePtr sheenTint;              ///< 0
    TexturePtr flatness;               ///< 0
    TexturePtr clearcoat;              ///< 0
    TexturePtr clearcoatGloss;         ///< 0
    std::optional<RelativeIndex> eta;  ///< takes precedence over `specular`
    float specular = 0.5f;             ///< sets eta = 2 / (1 - sqrt(0.08 specular)) - 1
    float diffuseReflectanceSamplingRate = 1;
    float mainSpecularSamplingRate = 1;
    float clearcoatSamplingRate = 1;
};
/// Throws Error for an eta that is not positive or, with dispersion, 1 at a wavelength, `specular` outside
/// [0, 1] and negative sampling rates.
BsdfPtr makePrincipled(const PrincipledParameters& parameters);

}  // namespace metrolux::core
