#pragma once
#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux::core {

/// What smooth and rough conductors have in common: how much they reflect.
class Metal {
  public:
    /// Null: eta 0, k 1, factor 1, a perfect mirror.
    Metal(const TexturePtr& eta, const TexturePtr& k, const TexturePtr& factor)
        : eta_(eta, 0),
          k_(k, 1),
          factor_(factor, 1),
          normalIncidence_(fresnelConductor(1, eta_.mean(), k_.mean())) {}

    /// Fresnel's reflectance with the factor; `cosine` >= 0 is that of the angle of incidence.
    Rgb reflectance(const SurfaceInteraction& si, float cosine) const {
        return factor_(si) * fresnelConductor(cosine, eta_(si), k_(si));
    }
    /// As Bsdf::albedo.
    Rgb albedo(const SurfaceInteraction& si) const {
        const bool constant = !eta_.texture() && !k_.texture();
        const Rgb f0 = constant ? normalIncidence_ : fresnelConductor(1, eta_(si), k_(si));
        return clampUnit(factor_(si) * schlickMean(f0));
    }

  private:
    ColorParameter eta_, k_, factor_;
    Rgb normalIncidence_;  ///< of Fresnel, where eta and k are constant
};

}  // namespace metrolux::core
