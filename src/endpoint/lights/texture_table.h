#pragma once
#include "base/distribution.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// Density over the unit uv square that follows the luminance of a texture. A tenth is uniform, so that no
/// point that emits is out of reach, whatever filtering and wrapping the texture does between its texels.
Distribution2D luminanceTable(const Texture& texture);

/// Value of a texture at a uv position that belongs to no surface.
Rgb textureAt(const Texture& texture, const Vec2f& uv);

}  // namespace metrolux::core
