#include "scattering/principled_thin.h"

#include "base/error.h"
#include "base/warp.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"
#include "scattering/principled_lobes.h"

namespace metrolux::core {
namespace {

using principled::schlickWeight;

/// Mirror in the plane of the surface.
Vec3f mirrored(const Vec3f& v) { return {v.x, v.y, -v.z}; }

class PrincipledThin final : public Bsdf {
  public:
    explicit PrincipledThin(const PrincipledThinParameters& p)
        : baseColor_(p.baseColor, 0.5f),
          roughness_(p.roughness, 0.5f),
          anisotropic_(p.anisotropic, 0),
          specTrans_(p.specTrans, 0),
          eta_(p.eta, 1.5f),
          specTint_(p.specTint, 0),
          sheen_(p.sheen, 0),
          sheenTint_(p.sheenTint, 0),
          flatness_(p.flatness, 0),
          diffTrans_(p.diffTrans, 0),
          diffuseReflectionRate_(p.diffuseReflectanceSamplingRate),
          diffuseTransmissionRate_(p.diffuseTransmittanceSamplingRate),
          specularReflectionRate_(p.specularReflectanceSamplingRate),
          specularTransmissionRate_(p.specularTransmittanceSamplingRate) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (known.z == 0) return std::nullopt;
        const Probabilities p = probabilities(specTrans_(si), diffuseShare(si));
        const Vec3f w = known.z > 0 ? known : -known;
        const float specular = p.specularReflection + p.specularTransmission;
        Vec3f direction;
        if (uLobe < p.specularReflection) {
            direction = reflectAbout(w, facets(si, false).sampleVisible(w, u));
            if (!(direction.z > 0)) return std::nullopt;
        } else if (uLobe < specular) {
            // No refraction in a thin sheet: a reflection that is folded to the other side.
            direction = mirrored(reflectAbout(w, facets(si, true).sampleVisible(w, u)));
            if (!(direction.z < 0)) return std::nullopt;
        } else {
            direction = warp::squareToCosineHemisphere(u);
            if (p.diffuseTransmission > 0 && uLobe >= specular + p.diffuseReflection) direction = -direction;
        }
        return finishSmooth(si, known, known.z > 0 ? direction : -direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& eye,
                            const Vec3f& light) const override {
        if (eye.z == 0 || light.z == 0) return {};
        const float side = eye.z > 0 ? 1.0f : -1.0f, specTrans = specTrans_(si), diffTrans = diffuseShare(si);
        const Vec3f wEye = eye * side, wLight = light * side;
        const bool reflect = wLight.z > 0;
        const Probabilities p = probabilities(specTrans, diffTrans);
        const Vec3f folded = reflect ? wLight : mirrored(wLight);  // on the side of wEye
        const Vec3f m = normalize(wEye + folded);
        const float cosHalf = dot(wEye, m);
        const Rgb baseColor = baseColor_(si);

        BsdfEvaluation result;
        const float diffuse = reflect ? p.diffuseReflection : p.diffuseTransmission;
        result.pdfLight = diffuse * warp::cosineHemispherePdf(folded);
        result.pdfEye = diffuse * warp::cosineHemispherePdf(wEye);
        if (specTrans > 0) addSpecular(si, p, specTrans, baseColor, wEye, wLight, m, cosHalf, result);
        if (!(specTrans < 1)) return result;
        if (!reflect) {
            result.value += baseColor * ((1.0f - specTrans) * diffTrans * kInvPi * folded.z);
        } else if (diffTrans < 1) {
            const float share = (1.0f - specTrans) * (1.0f - diffTrans) * wLight.z;
            const float shape =
                principled::diffuseShape(roughness_(si), flatness_(si), wEye.z, wLight.z, cosHalf);
            result.value += baseColor * (share * kInvPi * shape);
            if (const float sheen = sheen_(si); sheen > 0)
                result.value += lerp(sheenTint_(si), Rgb(1.0f), principled::tint(baseColor)) *
                                (share * sheen * schlickWeight(cosHalf));
        }
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const float f = specTrans_(si) * principled::reflectanceAtNormal(eta_(si));
        return clampUnit(Rgb(f + 0.05f * sheen_(si)) + baseColor_(si) * (1.0f - f));
    }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }
    bool isTransmissive() const override { return !specTrans_.isZero() || !diffTrans_.isZero(); }

  private:
    struct Probabilities {
        float specularReflection, specularTransmission, diffuseReflection, diffuseTransmission;
    };
    Probabilities probabilities(float specTrans, float diffTrans) const {
        const Probabilities p{0.5f * specTrans * specularReflectionRate_,
                              0.5f * specTrans * specularTransmissionRate_,
                              (1.0f - specTrans) * (1.0f - diffTrans) * diffuseReflectionRate_,
                              (1.0f - specTrans) * diffTrans * diffuseTransmissionRate_};
        const float total =
            p.specularReflection + p.specularTransmission + p.diffuseReflection + p.diffuseTransmission;
        const float scale = total > 0 ? 1.0f / total : 0.0f;
        return {p.specularReflection * scale, p.specularTransmission * scale, p.diffuseReflection * scale,
                p.diffuseTransmission * scale};
    }

    /// Both specular lobes. Directions are flipped so that wEye.z > 0; m is the half vector on that side.
    void addSpecular(const SurfaceInteraction& si, const Probabilities& p, float specTrans,
                     const Rgb& baseColor, const Vec3f& wEye, const Vec3f& wLight, const Vec3f& m,
                     float cosHalf, BsdfEvaluation& result) const {
        const bool reflect = wLight.z > 0;
        const Vec3f folded = reflect ? wLight : mirrored(wLight);
        const MicrofacetDistribution distribution = facets(si, !reflect);
        const float d = distribution.d(m), eta = eta_(si);
        // From the light's end the same facet appears mirrored, with the same D. The density is that of the
        // sampler before it knows whether the value is dropped.
        const float chosen = 0.25f * (reflect ? p.specularReflection : p.specularTransmission);
        result.pdfLight += chosen * distribution.visiblePdfOverCosine(wEye, m, d);
        result.pdfEye += chosen * distribution.visiblePdfOverCosine(folded, m, d);
        // g1 is zero for a facet that wLight, on its own side, would see from behind.
        const float dg = d * distribution.g1(wEye, m) * distribution.g1(wLight, m) / (4.0f * wEye.z);
        const float fresnel = fresnelDielectric(cosHalf, eta);
        if (reflect)
            result.value += tintedFresnel(si, baseColor, fresnel, eta, cosHalf) * (specTrans * dg);
        else
            result.value += baseColor * (specTrans * (1.0f - fresnel) * dg);
    }

    Rgb tintedFresnel(const SurfaceInteraction& si, const Rgb& baseColor, float fresnel, float eta,
                      float cosine) const {
        const float specTint = specTint_(si);
        if (!(specTint > 0)) return Rgb(fresnel);
        const float refracted = safeSqrt(1.0f - (1.0f - cosine * cosine) / sqr(eta));
        const Rgb r0 = principled::tint(baseColor) * principled::reflectanceAtNormal(eta);
        const Rgb schlick = lerp(schlickWeight(eta > 1 ? cosine : refracted), r0, Rgb(1.0f));
        return lerp(specTint, Rgb(fresnel), schlick);
    }

    /// Transmission blurs less than reflection [Burley15, figure 15].
    MicrofacetDistribution facets(const SurfaceInteraction& si, bool transmission) const {
        const float scale = transmission ? 0.65f * eta_(si) - 0.35f : 1.0f;
        return principled::facets(scale * roughness_(si), anisotropic_(si));
    }
    float diffuseShare(const SurfaceInteraction& si) const { return 0.5f * diffTrans_(si); }

    ColorParameter baseColor_;
    ScalarParameter roughness_, anisotropic_, specTrans_, eta_, specTint_, sheen_, sheenTint_, flatness_,
        diffTrans_;
    float diffuseReflectionRate_, diffuseTransmissionRate_, specularReflectionRate_,
        specularTransmissionRate_;
};

}  // namespace

BsdfPtr makePrincipledThin(const PrincipledThinParameters& p) {
    for (const float rate : {p.diffuseReflectanceSamplingRate, p.diffuseTransmittanceSamplingRate,
                             p.specularReflectanceSamplingRate, p.specularTransmittanceSamplingRate})
        if (!(rate >= 0) || !std::isfinite(rate))
            throw Error("principled thin: a sampling rate is {}, expected a number that is not negative",
                        rate);
    return std::make_shared<PrincipledThin>(p);
}

}  // namespace metrolux::core
