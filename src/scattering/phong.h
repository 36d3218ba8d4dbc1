#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// The modified Phong model [Lafortune & Willems 1994] of Mitsuba 0.6 (`phong`), on the side of the normal;
/// the other side is black. A texture that is null has the value given beside it. When the largest sum of the
/// two reflectances exceeds 1, both are scaled to 0.99 of it, as 0.6 does.
struct PhongParameters {
    TexturePtr diffuseReflectance;   ///< 0.5
    TexturePtr specularReflectance;  ///< 0.2
    TexturePtr exponent;             ///< 30
};
BsdfPtr makePhong(const PhongParameters& parameters);

}  // namespace metrolux::core
