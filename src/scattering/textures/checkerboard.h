#pragma once
#include "scattering/texture.h"
#include "scattering/textures/uv_transform.h"

namespace metrolux::core {

/// Two by two squares on the unit square of uv: color0 on the diagonal that contains the origin, color1
/// elsewhere.
struct CheckerboardParameters {
    TexturePtr color0, color1;
    UvTransform toUv;
};
TexturePtr makeCheckerboard(const CheckerboardParameters& parameters);

}  // namespace metrolux::core
