#include "scattering/separate_plastic.h"

#include "base/error.h"
#include "base/warp.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class SeparatePlastic final : public Bsdf {
  public:
    explicit SeparatePlastic(const SeparatePlasticParameters& p)
        : eta_(p.eta),
          diffuse_(p.diffuseReflectance, 0.5f),
          specular_(p.specularReflectance, 1),
          alphaU_(p.alphaU, 0.1f),
          alphaV_(p.alphaV, 0.1f),
          distribution_(p.distribution) {
        specularWeight_ = specularShare(diffuse_, specular_);
    }

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        const Vec3f direction = uLobe < specularWeight_
                                    ? reflectAbout(known, facets(si).sampleVisible(known, u))
                                    : warp::squareToCosineHemisphere(u);
        if (!(direction.z > 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const float passed = (1 - fresnelDielectric(wEye.z, eta_)) * (1 - fresnelDielectric(wLight.z, eta_));
        BsdfEvaluation result;
        result.value = diffuse_(si) * (kInvPi * wLight.z * passed);
        result.pdfLight = (1 - specularWeight_) * warp::cosineHemispherePdf(wLight);
        result.pdfEye = (1 - specularWeight_) * warp::cosineHemispherePdf(wEye);

        const MicrofacetDistribution surface = facets(si);
        const Vec3f m = normalize(wEye + wLight);
        const float d = surface.d(m);
        if (d == 0) return result;
        const float g = surface.g1(wEye, m) * surface.g1(wLight, m);
        result.value += specular_(si) * (fresnelDielectric(dot(wEye, m), eta_) * d * g / (4 * wEye.z));
        result.pdfLight += 0.25f * specularWeight_ * surface.visiblePdfOverCosine(wEye, m, d);
        result.pdfEye += 0.25f * specularWeight_ * surface.visiblePdfOverCosine(wLight, m, d);
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const float external = fresnelDiffuseReflectance(eta_);
        return clampUnit(specular_(si) * external + diffuse_(si) * sqr(1 - external));
    }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }

  private:
    MicrofacetDistribution facets(const SurfaceInteraction& si) const {
        return {distribution_, alphaU_(si), alphaV_(si)};
    }

    float eta_;
    ColorParameter diffuse_, specular_;
    ScalarParameter alphaU_, alphaV_;
    MicrofacetType distribution_;
    float specularWeight_;
};

}  // namespace

BsdfPtr makeSeparatePlastic(const SeparatePlasticParameters& parameters) {
    if (!(parameters.eta > 0) || !std::isfinite(parameters.eta) || parameters.eta == 1)
        throw Error(
            "plastic: the ratio of the indices of refraction is {}, expected a positive number other than 1",
            parameters.eta);
    return std::make_shared<SeparatePlastic>(parameters);
}

}  // namespace metrolux::core
