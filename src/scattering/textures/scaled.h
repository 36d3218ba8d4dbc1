#pragma once
#include "scattering/texture.h"

namespace metrolux::core {

/// A texture times a factor for each channel.
struct ScaledTextureParameters {
    TexturePtr texture;
    Rgb scale{1.0f};
};
TexturePtr makeScaledTexture(const ScaledTextureParameters& parameters);

}  // namespace metrolux::core
