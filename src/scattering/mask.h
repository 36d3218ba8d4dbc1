#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A surface that is there with the weight `opacity` (clamped to [0, 1]) and lets the rest pass straight on.
struct MaskParameters {
    TexturePtr opacity;  ///< 0.5 when null
    BsdfPtr nested;
};
BsdfPtr makeMask(const MaskParameters& parameters);

}  // namespace metrolux::core
