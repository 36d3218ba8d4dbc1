#pragma once
#include "scattering/bsdf.h"
#include "scattering/microfacet.h"
#include "scattering/texture.h"

namespace metrolux::core {

/// The intensities of Mitsuba 3's `pplastic`: a rough reflection, and a diffuse one that loses what a smooth
/// interface reflects on the ways in and out, without further reflections between the two [Baek et al. 2018,
/// Simultaneous Acquisition of Polarimetric SVBRDF and Normals]. The side of the normal only. A texture that
/// is null has the value given beside it.
struct SeparatePlasticParameters {
    float eta = 1.49f / 1.000277f;   ///< index of the interior over that of the exterior
    TexturePtr diffuseReflectance;   ///< 0.5
    TexturePtr specularReflectance;  ///< factor; 1
    TexturePtr alphaU, alphaV;       ///< roughness; 0.1
    MicrofacetType distribution = MicrofacetType::Beckmann;
};
/// Throws Error unless eta is positive, finite and not 1.
BsdfPtr makeSeparatePlastic(const SeparatePlasticParameters& parameters);

}  // namespace metrolux::core
