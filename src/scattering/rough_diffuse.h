#pragma once
#include "scattering/bsdf.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// Rough diffuse reflection: V-cavities of Lambertian facets [Oren & Nayar 1994, Generalization of Lambert's
/// Reflectance Model], their functional approximation with one interreflection. It reflects on the side of
/// the normal.
struct RoughDiffuseParameters {
    TexturePtr reflectance;  ///< of the facets; 0.5 when null
    TexturePtr
        alpha;  ///< root mean square slope, 0.2 when null; the paper's sigma (radians) is alpha / sqrt(2)
    bool fastApproximation = false;  ///< the paper's qualitative model, without interreflection
};
BsdfPtr makeRoughDiffuse(const RoughDiffuseParameters& parameters);

}  // namespace metrolux::core
