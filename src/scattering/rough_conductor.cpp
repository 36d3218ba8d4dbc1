#include "scattering/rough_conductor.h"

#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux {
namespace {

class RoughConductor final : public Bsdf {
  public:
    explicit RoughConductor(const RoughConductorParameters& p)
        : eta_(p.eta, 0),
          k_(p.k, 1),
          reflectance_(p.specularReflectance, 1),
          alphaU_(p.alphaU, 0.1f),
          alphaV_(p.alphaV, 0.1f),
          type_(p.distribution),
          normalIncidence_(fresnelConductor(1, eta_.mean(), k_.mean())) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        const Vec3f direction = reflectAbout(known, distribution(si).sampleVisible(known, u));
        if (!(direction.z > 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const MicrofacetDistribution facets = distribution(si);
        const Vec3f m = normalize(wEye + wLight);
        const float d = facets.d(m);
        if (d == 0) return {};
        const Rgb fresnel = fresnelConductor(dot(wEye, m), eta_(si), k_(si));
        // S = F D G / (4 cos wEye)  [Walter07, 20]
        const float scale = d * facets.g1(wEye, m) * facets.g1(wLight, m) / (4.0f * wEye.z);
        return {reflectance_(si) * fresnel * scale, 0.25f * facets.visiblePdfOverCosine(wEye, m, d),
                0.25f * facets.visiblePdfOverCosine(wLight, m, d)};
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        // Schlick's hemispherical mean F0 + (1 - F0) / 21
        const Rgb normalIncidence =
            eta_.texture() || k_.texture() ? fresnelConductor(1, eta_(si), k_(si)) : normalIncidence_;
        return clampUnit(reflectance_(si) * (normalIncidence * (20.0f / 21.0f) + Rgb(1.0f / 21.0f)));
    }
    bool hasSmoothLobe() const override { return true; }
    bool isNarrow(const SurfaceInteraction& si) const override {
        return std::max(alphaU_(si), alphaV_(si)) < kNarrow;
    }
    bool hasDeltaLobe() const override { return false; }

  private:
    MicrofacetDistribution distribution(const SurfaceInteraction& si) const {
        return {type_, alphaU_(si), alphaV_(si)};
    }

    ColorParameter eta_, k_, reflectance_;
    ScalarParameter alphaU_, alphaV_;
    MicrofacetType type_;
    Rgb normalIncidence_;  ///< Fresnel reflectance, where eta and k are constant
};

}  // namespace

BsdfPtr makeRoughConductor(const RoughConductorParameters& parameters) {
    return std::make_shared<RoughConductor>(parameters);
}

}  // namespace metrolux
