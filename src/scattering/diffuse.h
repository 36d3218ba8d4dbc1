#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// Lambertian reflection on the side of the normal; the other side is black.
struct DiffuseParameters {
    TexturePtr reflectance;  ///< clamped to [0, 1]; 0.5 when null
};
BsdfPtr makeDiffuse(const DiffuseParameters& parameters);

}  // namespace metrolux::core
