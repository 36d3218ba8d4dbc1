#pragma once
#include "scattering/parameter.h"

namespace metrolux::core {

/// The two reflectances of the models that Mitsuba 0.6 knew before microfacets, which do not conserve energy
/// by themselves.
class DiffuseSpecular {
  public:
    /// Scales both colors when their largest sum exceeds 1 (to 0.99). Texels are looked at where a texture
    /// has a resolution; otherwise its mean stands for it.
    DiffuseSpecular(TexturePtr diffuse, float defaultDiffuse, TexturePtr specular, float defaultSpecular);

    Rgb diffuse(const SurfaceInteraction& si) const { return diffuse_(si) * scale_; }
    Rgb specular(const SurfaceInteraction& si) const { return specular_(si) * scale_; }
    Rgb sum(const SurfaceInteraction& si) const { return clampUnit(diffuse(si) + specular(si)); }
    float specularProbability() const { return specularProbability_; }

  private:
    ColorParameter diffuse_, specular_;
    float scale_ = 1;
    float specularProbability_ = 0;
};

}  // namespace metrolux::core
