#include "scattering/rough_dielectric.h"

#include "base/error.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class RoughDielectric final : public Bsdf {
  public:
    explicit RoughDielectric(const RoughDielectricParameters& p)
        : eta_(p.eta),
          reflectance_(p.specularReflectance, 1),
          transmittance_(p.specularTransmittance, 1),
          alphaU_(p.alphaU, 0.1f),
          alphaV_(p.alphaV, 0.1f),
          type_(p.distribution) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (known.z == 0) return std::nullopt;
        const Vec3f m = distribution(si).sampleVisible(known.z > 0 ? known : -known, u);
        float cosThetaT, etaIt, etaTi;
        const float f = fresnelDielectric(dot(known, m), eta_(si), cosThetaT, etaIt, etaTi);
        const bool reflect = uLobe < f;
        const Vec3f direction =
            reflect ? reflectAbout(known, m) : normalize(refractAbout(known, m, cosThetaT, etaTi));
        if (!(reflect ? known.z * direction.z > 0 : known.z * direction.z < 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode, reflect ? 1.0f : etaIt);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (wEye.z == 0 || wLight.z == 0) return {};
        const bool reflect = wEye.z * wLight.z > 0;
        const float relative = eta_(si);
        // Index on the side of wLight over that on the side of wEye
        const float eta = reflect ? 1.0f : wEye.z > 0 ? relative : 1.0f / relative;
        Vec3f m = wEye + wLight * eta;  // [Walter07, 13 and 16]
        const float length2 = lengthSquared(m);
        if (!(length2 > 0)) return {};
        m *= (m.z < 0 ? -1.0f : 1.0f) / std::sqrt(length2);
        const float eyeM = dot(wEye, m), lightM = dot(wLight, m);
        if (!(eyeM * wEye.z > 0 && lightM * wLight.z > 0)) return {};  // a facet seen from behind

        const MicrofacetDistribution facets = distribution(si);
        const float d = facets.d(m);
        if (d == 0) return {};
        const float f = fresnelDielectric(eyeM, relative);
        const float dg = d * facets.g1(wEye, m) * facets.g1(wLight, m) / std::abs(wEye.z);
        const float pdfEyeSide = facets.visiblePdfOverCosine(wEye, m, d);
        const float pdfLightSide = facets.visiblePdfOverCosine(wLight, m, d);
        if (reflect)
            return {reflectance_(si) * (0.25f * f * dg), 0.25f * f * pdfEyeSide, 0.25f * f * pdfLightSide};
        // [Walter07, 17 and 21], times 1 / eta^2 for radiance: the eta^2 of the Jacobian cancels in S and
        // stays in the density of wLight. The denominator (wEye.m + eta wLight.m)^2 is the squared length of
        // the half vector.
        const float t = (1.0f - f) * std::abs(eyeM * lightM) / length2;
        return {transmittance_(si) * (t * dg), t * eta * eta * pdfEyeSide, t * pdfLightSide};
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const Rgb r = reflectance_(si), t = transmittance_(si);
        return clampUnit({std::max(r.x, t.x), std::max(r.y, t.y), std::max(r.z, t.z)});
    }
    bool hasSmoothLobe() const override { return true; }
    bool isNarrow(const SurfaceInteraction& si) const override {
        return std::max(alphaU_(si), alphaV_(si)) < kNarrow;
    }
    bool hasDeltaLobe() const override { return false; }
    bool isTransmissive() const override { return true; }
    bool isDispersive() const override { return eta_.isDispersive(); }

  private:
    MicrofacetDistribution distribution(const SurfaceInteraction& si) const {
        return {type_, alphaU_(si), alphaV_(si)};
    }

    RelativeIndex eta_;
    ColorParameter reflectance_, transmittance_;
    ScalarParameter alphaU_, alphaV_;
    MicrofacetType type_;
};

}  // namespace

BsdfPtr makeRoughDielectric(const RoughDielectricParameters& parameters) {
    const float eta = parameters.eta.atLineD();
    if (!(eta > 0) || !std::isfinite(eta) || parameters.eta.passesOne())
        throw Error(
            "rough dielectric: the ratio of the indices of refraction is {}, expected a positive number "
            "other than 1",
            eta > 0 && std::isfinite(eta) ? 1.0f : eta);
    return std::make_shared<RoughDielectric>(parameters);
}

}  // namespace metrolux::core
