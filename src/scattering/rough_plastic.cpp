#include "scattering/rough_plastic.h"

#include "base/error.h"
#include "base/parallel.h"
#include "base/warp.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"

#include <array>

namespace metrolux::core {
namespace {

class RoughPlastic final : public Bsdf {
  public:
    explicit RoughPlastic(const RoughPlasticParameters& p)
        : eta_(p.eta),
          diffuse_(p.diffuseReflectance, 0.5f),
          specular_(p.specularReflectance, 1),
          nonlinear_(p.nonlinear),
          facets_(p.distribution, p.alpha, p.alpha) {
        const float diffuseMean = average(diffuse_.mean()), specularMean = average(specular_.mean());
        specularWeight_ = specularMean > 0 ? specularMean / (diffuseMean + specularMean) : 0.0f;
        tabulate();
    }

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        const bool specular = uLobe < probabilityOfSpecular(transmittance(known.z));
        const Vec3f direction = specular ? reflectAbout(known, facets_.sampleVisible(known, u))
                                         : warp::squareToCosineHemisphere(u);
        if (!(direction.z > 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const float tEye = transmittance(wEye.z), tLight = transmittance(wLight.z);
        const float specularEye = probabilityOfSpecular(tEye), specularLight = probabilityOfSpecular(tLight);
        BsdfEvaluation result;
        result.value = base(si) * (kInvPi * wLight.z * tEye * tLight / (eta_ * eta_));
        result.pdfLight = (1.0f - specularEye) * warp::cosineHemispherePdf(wLight);
        result.pdfEye = (1.0f - specularLight) * warp::cosineHemispherePdf(wEye);

        const Vec3f m = normalize(wEye + wLight);
        const float d = facets_.d(m);
        if (d == 0) return result;
        const float fresnel = fresnelDielectric(dot(wEye, m), eta_);
        const float g = facets_.g1(wEye, m) * facets_.g1(wLight, m);
        result.value += specular_(si) * (fresnel * d * g / (4.0f * wEye.z));
        result.pdfLight += 0.25f * specularEye * facets_.visiblePdfOverCosine(wEye, m, d);
        result.pdfEye += 0.25f * specularLight * facets_.visiblePdfOverCosine(wLight, m, d);
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const float external = fresnelDiffuseReflectance(eta_);
        return clampUnit(specular_(si) * external + base(si) * ((1.0f - external) * (1.0f - internal_)));
    }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }

  private:
    /// Transmittance of the coat from outside at kSize equidistant cosines, and its diffuse reflectance from
    /// inside: the same nodes and quadratures as in Mitsuba 3, so that the images agree. From inside the
    /// integrand has a jump (total reflection) and takes more nodes.
    void tabulate() {
        std::array<float, kSize> reflectance;
        parallelFor(kSize, [&](size_t i) {
            const float cosine = std::max(1e-6f, static_cast<float>(i) / (kSize - 1));
            const Vec3f w(safeSqrt(1.0f - cosine * cosine), 0, cosine);
            const auto nodes = [](float eta) { return eta > 1 ? 32 : 128; };
            transmittance_[i] = microfacetTransmittance(facets_, w, eta_, nodes(eta_));
            reflectance[i] = cosine * microfacetReflectance(facets_, w, 1.0f / eta_, nodes(1.0f / eta_));
        });
        internal_ = 0;
        for (const float r : reflectance) internal_ += 2.0f * r / kSize;
    }

    float transmittance(float cosine) const {
        const float x = cosine * (kSize - 1);
        const size_t i = std::min(static_cast<size_t>(x), kSize - 2);
        return lerp(x - static_cast<float>(i), transmittance_[i], transmittance_[i + 1]);
    }

    /// Reflectance of the base with all internal reflections, a geometric series.
    Rgb base(const SurfaceInteraction& si) const {
        const Rgb d = diffuse_(si);
        if (!nonlinear_) return d * (1.0f / (1.0f - internal_));
        return {d.x / (1.0f - d.x * internal_), d.y / (1.0f - d.y * internal_),
                d.z / (1.0f - d.z * internal_)};
    }

    float probabilityOfSpecular(float transmitted) const {
        const float specular = (1.0f - transmitted) * specularWeight_;
        const float diffuse = transmitted * (1.0f - specularWeight_);
        return specular > 0 ? specular / (specular + diffuse) : 0.0f;
    }

    static constexpr size_t kSize = 64;
    float eta_;
    ColorParameter diffuse_, specular_;
    bool nonlinear_;
    MicrofacetDistribution facets_;
    std::array<float, kSize> transmittance_;
    float internal_ = 0;
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
