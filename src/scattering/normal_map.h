#pragma once
#include "scattering/perturbed.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A nested model whose shading normal comes from a texture: rgb in [0, 1] is (n + 1) / 2 in the local
/// shading frame.
struct NormalMapParameters {
    TexturePtr normals;
    BsdfPtr nested;
    PerturbationOptions options;
};
BsdfPtr makeNormalMap(const NormalMapParameters& parameters);

}  // namespace metrolux::core
