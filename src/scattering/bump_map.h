#pragma once
#include "scattering/perturbed.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A nested model on a surface displaced by a height texture, as far as the shading normal shows it.
struct BumpMapParameters {
    TexturePtr height;
    float scale = 1;  ///< of the gradient
    BsdfPtr nested;
    PerturbationOptions options;
};
BsdfPtr makeBumpMap(const BumpMapParameters& parameters);

}  // namespace metrolux::core
