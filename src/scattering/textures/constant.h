#pragma once
#include "scattering/texture.h"

namespace metrolux {

/// The same value everywhere.
TexturePtr makeConstantTexture(const Rgb& value);

}  // namespace metrolux
