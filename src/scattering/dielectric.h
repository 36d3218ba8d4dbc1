#pragma once
#include "scattering/bsdf.h"
#include "scattering/refractive_index.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A smooth interface between two dielectrics; the normal points to the exterior.
struct DielectricParameters {
    RelativeIndex eta = 1.5046f / 1.000277f;  ///< bk7 in air
    TexturePtr specularReflectance = {};      ///< factor; 1 when null
    TexturePtr specularTransmittance = {};    ///< factor; 1 when null
};
/// Throws Error unless eta is positive and finite.
BsdfPtr makeDielectric(const DielectricParameters& parameters);

}  // namespace metrolux::core
