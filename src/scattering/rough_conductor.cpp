#include "scattering/rough_conductor.h"

#include "scattering/metal.h"

namespace metrolux::core {
namespace {

class RoughConductor final : public Bsdf {
  public:
    explicit RoughConductor(const RoughConductorParameters& p)
        : metal_(p.eta, p.k, p.specularReflectance),
          alphaU_(p.alphaU, 0.1f),
          alphaV_(p.alphaV, 0.1f),
          type_(p.distribution) {}

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
        // S = F D G / (4 cos wEye)  [Walter07, 20]
        const float scale = d * facets.g1(wEye, m) * facets.g1(wLight, m) / (4.0f * wEye.z);
        return {metal_.reflectance(si, dot(wEye, m)) * scale, 0.25f * facets.visiblePdfOverCosine(wEye, m, d),
                0.25f * facets.visiblePdfOverCosine(wLight, m, d)};
    }

    Rgb albedo(const SurfaceInteraction& si) const override { return metal_.albedo(si); }
    bool hasSmoothLobe() const override { return true; }
    bool isNarrow(const SurfaceInteraction& si) const override {
        return std::max(alphaU_(si), alphaV_(si)) < kNarrow;
    }
    bool hasDeltaLobe() const override { return false; }

  private:
    MicrofacetDistribution distribution(const SurfaceInteraction& si) const {
        return {type_, alphaU_(si), alphaV_(si)};
    }

    Metal metal_;
    ScalarParameter alphaU_, alphaV_;
    MicrofacetType type_;
};

}  // namespace

BsdfPtr makeRoughConductor(const RoughConductorParameters& parameters) {
    return std::make_shared<RoughConductor>(parameters);
}

}  // namespace metrolux::core
