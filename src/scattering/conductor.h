#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// A smooth metal on the side of the normal; the other side is black. The defaults are a perfect mirror.
struct ConductorParameters {
    TexturePtr eta;                  ///< real part of the index relative to the exterior; 0 when null
    TexturePtr k;                    ///< imaginary part; 1 when null
    TexturePtr specularReflectance;  ///< factor; 1 when null
};
BsdfPtr makeConductor(const ConductorParameters& parameters);

}  // namespace metrolux::core
