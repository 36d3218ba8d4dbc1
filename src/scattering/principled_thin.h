#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// Mitsuba 3's `principledthin`: the principled model for sheets without thickness (leaves, paper, windows),
/// the same from both sides. A texture that is null has the value given beside it.
///
/// Its specular transmission is not reciprocal in Mitsuba at grazing angles: the value is dropped where
/// wLight would see a facet from behind that is oriented with respect to wEye. The value here is the same.
struct PrincipledThinParameters {
    TexturePtr baseColor;    ///< 0.5
    TexturePtr roughness;    ///< 0.5
    TexturePtr anisotropic;  ///< 0
    TexturePtr specTrans;    ///< 0
    TexturePtr eta;          ///< index over that of the surroundings; 1.5
    TexturePtr specTint;     ///< 0
    TexturePtr sheen;        ///< 0
    TexturePtr sheenTint;    ///< 0
    TexturePtr flatness;     ///< 0
    TexturePtr diffTrans;    ///< share of the diffuse light that is transmitted, times 2: in [0, 2]; 0
    float diffuseReflectanceSamplingRate = 1;
    float diffuseTransmittanceSamplingRate = 1;
    float specularReflectanceSamplingRate = 1;
    float specularTransmittanceSamplingRate = 1;
};
/// Throws Error for negative sampling rates.
BsdfPtr makePrincipledThin(const PrincipledThinParameters& parameters);

}  // namespace metrolux::core
