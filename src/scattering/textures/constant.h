#pragma once
#include "scattering/texture.h"

namespace metrolux::core {

/// The same value everywhere.
TexturePtr makeConstantTexture(const Rgb& value);

}  // namespace metrolux::core
