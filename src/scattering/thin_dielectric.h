#pragma once
#include "scattering/bsdf.h"
#include "scattering/refractive_index.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A thin sheet of a dielectric: reflection and straight transmission, with all inner reflections counted.
struct ThinDielectricParameters {
    RelativeIndex eta = 1.5046f / 1.000277f;  ///< of the sheet over what is around it: bk7 in air
    TexturePtr specularReflectance = {};      ///< factor; 1 when null
    TexturePtr specularTransmittance = {};    ///< factor; 1 when null
};
/// Throws Error unless eta is positive and finite.
BsdfPtr makeThinDielectric(const ThinDielectricParameters& parameters);

}  // namespace metrolux::core
