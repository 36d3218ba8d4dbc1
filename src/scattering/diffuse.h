#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux {

/// Lambertian reflection on the side of the normal; the other side is black.
struct DiffuseParameters {
    TexturePtr reflectance;
};
BsdfPtr makeDiffuse(const DiffuseParameters& parameters);

}  // namespace metrolux
