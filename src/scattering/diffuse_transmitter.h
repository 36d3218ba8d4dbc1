#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// Ideally diffuse transmission, from either side to the other: the light that is not transmitted is
/// absorbed.
struct DiffuseTransmitterParameters {
    TexturePtr transmittance;  ///< 0.5 when null
};
BsdfPtr makeDiffuseTransmitter(const DiffuseTransmitterParameters& parameters);

}  // namespace metrolux::core
