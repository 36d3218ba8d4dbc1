#include "scattering/rough_plastic.h"

#include "base/error.h"
#include "base/warp.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"
#include "scattering/rough_interface.h"

namespace metrolux::core {
namespace {

class RoughPlastic final : public Bsdf {
  public:
    explicit RoughPlastic(const RoughPlasticParameters& p)
        : eta_(p.eta),
          diffuse_(p.diffuseReflectance, 0.5f),
          specular_(p.specularReflectance, 1),
          nonlinear_(p.nonlinear),
          coat_(p.alphaTexture
                    ? RoughInterface(p.distribution, p.alphaTexture, p.eta, true)
                    : RoughInterface(MicrofacetDistribution(p.distribution, p.alpha, p.alpha), p.eta, true)) {
        specularWeight_ = specularShare(diffuse_, specular_);
    }

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        const RoughInterface::At coat = coat_(si);
        const bool specular = uLobe < probabilityOfSpecular(coat.transmittance(known.z));
        const Vec3f direction = specular ? reflectAbout(known, coat.facets.sampleVisible(known, u))
                                         : warp::squareToCosineHemisphere(u);
        if (!(direction.z > 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const RoughInterface::At coat = coat_(si);
        const float tEye = coat.transmittance(wEye.z), tLight = coat.transmittance(wLight.z);
        const float specularEye = probabilityOfSpecular(tEye), specularLight = probabilityOfSpecular(tLight);
        BsdfEvaluation result;
        result.value = base(si, coat.internal()) * (kInvPi * wLight.z * tEye * tLight / (eta_ * eta_));
        result.pdfLight = (1.0f - specularEye) * warp::cosineHemispherePdf(wLight);
        result.pdfEye = (1.0f - specularLight) * warp::cosineHemispherePdf(wEye);

        const Vec3f m = normalize(wEye + wLight);
        const float d = coat.facets.d(m);
        if (d == 0) return result;
        const float fresnel = fresnelDielectric(dot(wEye, m), eta_);
        const float g = coat.facets.g1(wEye, m) * coat.facets.g1(wLight, m);
        result.value += specular_(si) * (fresnel * d * g / (4.0f * wEye.z));
        result.pdfLight += 0.25f * specularEye * coat.facets.visiblePdfOverCosine(wEye, m, d);
        result.pdfEye += 0.25f * specularLight * coat.facets.visiblePdfOverCosine(wLight, m, d);
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const float external = fresnelDiffuseReflectance(eta_), internal = coat_(si).internal();
        return clampUnit(specular_(si) * external +
                         base(si, internal) * ((1.0f - external) * (1.0f - internal)));
    }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }

  private:
    /// Reflectance of the base with all internal reflections, a geometric series.
    Rgb base(const SurfaceInteraction& si, float internal) const {
        const Rgb d = diffuse_(si);
        if (!nonlinear_) return d * (1.0f / (1.0f - internal));
        return {d.x / (1.0f - d.x * internal), d.y / (1.0f - d.y * internal), d.z / (1.0f - d.z * internal)};
    }

    float probabilityOfSpecular(float transmitted) const {
        const float specular = (1.0f - transmitted) * specularWeight_;
        const float diffuse = transmitted * (1.0f - specularWeight_);
        return specular > 0 ? specular / (specular + diffuse) : 0.0f;
    }

    float eta_;
    ColorParameter diffuse_, specular_;
    bool nonlinear_;
    RoughInterface coat_;
    float specularWeight_;
};

}  // namespace

BsdfPtr makeRoughPlastic(const RoughPlasticParameters& parameters) {
    if (!(parameters.eta > 0) || !std::isfinite(parameters.eta) || parameters.eta == 1)
        throw Error(
            "rough plastic: the ratio of the indices of refraction is {}, expected a positive number other "
            "than 1",
            parameters.eta);
    return std::make_shared<RoughPlastic>(parameters);
}

}  // namespace metrolux::core
