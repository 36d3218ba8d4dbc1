#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// (1 - weight) * first + weight * second.
struct BlendParameters {
    TexturePtr weight;  ///< clamped to [0, 1]; 0.5 when null
    BsdfPtr first, second;
};
BsdfPtr makeBlend(const BlendParameters& parameters);

}  // namespace metrolux::core
