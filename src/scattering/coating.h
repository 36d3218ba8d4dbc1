#pragma once
#include "scattering/bsdf.h"
#include "scattering/microfacet.h"
#include "scattering/texture.h"

#include <optional>

namespace metrolux::core {

/// A layer of clear or colored varnish over another BSDF, which must not transmit light [Weidlich & Wilkie
/// 2007, Arbitrarily Layered Micro-Facet Surfaces]: light is reflected at the outside, or refracted,
/// scattered once by the base, refracted out and absorbed on both ways. What the layer reflects back inside
/// is lost, as in Mitsuba 0.6.
struct CoatingParameters {
    float eta = 1.5f / 1.000277f;    ///< index of the layer over that of the outside
    float thickness = 1;             ///< in units of 1 / sigmaA
    TexturePtr sigmaA;               ///< absorption coefficient; 0 when null
    TexturePtr specularReflectance;  ///< 1 when null
    BsdfPtr base;
    std::optional<MicrofacetDistribution> facets;  ///< of the outside; absent: smooth
    TexturePtr alpha;                              ///< roughness of the outside, in place of `facets`
    MicrofacetType distribution = MicrofacetType::Beckmann;  ///< of it
};
/// Throws Error for an index that is not positive, for a negative thickness and for a base that transmits.
BsdfPtr makeCoating(const CoatingParameters& parameters);

}  // namespace metrolux::core
