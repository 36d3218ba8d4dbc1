#include "scattering/principled.h"

#include "base/error.h"
#include "base/warp.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"
#include "scattering/principled_lobes.h"

namespace metrolux::core {
namespace {

using principled::Clearcoat;
using principled::schlickWeight;

/// Index ratio that the parameters stand for. Matched indices cannot refract: as in Mitsuba they are moved
/// apart. What transmits nothing has one index for all wavelengths.
RelativeIndex indexRatio(const PrincipledParameters& p, bool transmits) {
    if (p.eta && !transmits) return p.eta->atLineD();
    if (p.eta) return !p.eta->isDispersive() && p.eta->atLineD() == 1 ? RelativeIndex(1.001f) : *p.eta;
    const float specular = transmits && p.specular == 0 ? 1e-3f : p.specular;
    return 2.0f / (1.0f - std::sqrt(0.08f * specular)) - 1.0f;
}

class Principled final : public Bsdf {
  public:
    explicit Principled(const PrincipledParameters& p)
        : baseColor_(p.baseColor, 0.5f),
          roughness_(p.roughness, 0.5f),
          anisotropic_(p.anisotropic, 0),
          metallic_(p.metallic, 0),
          specTrans_(p.specTrans, 0),
          specTint_(p.specTint, 0),
          sheen_(p.sheen, 0),
          sheenTint_(p.sheenTint, 0),
          flatness_(p.flatness, 0),
          clearcoat_(p.clearcoat, 0),
          clearcoatGloss_(p.clearcoatGloss, 0),
          eta_(indexRatio(p, !specTrans_.isZero())),
          diffuseRate_(p.diffuseReflectanceSamplingRate),
          specularRate_(p.mainSpecularSamplingRate),
          clearcoatRate_(p.clearcoatSamplingRate) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        const Weights w = weights(si);
        const bool front = known.z > 0;
        if (known.z == 0 || (!front && !(w.bsdf > 0))) return std::nullopt;
        const float diffuse = front ? diffuseRate_ * w.brdf : 0.0f, coat = front ? coatRate(w) : 0.0f;
        // The two specular lobes share a facet, so that its Fresnel term can split them.
        float x = uLobe * totalRate(w, front);
        if (x < diffuse) return finishSmooth(si, known, warp::squareToCosineHemisphere(u), mode);
        x -= diffuse;
        Vec3f direction;
        if (x < coat) {
            direction = reflectAbout(known, Clearcoat(clearcoatGloss_(si)).sample(u));
        } else {
            x -= coat;
            const Vec3f m = facets(si).sampleVisible(front ? known : -known, u);
            float cosThetaT, etaIt, etaTi;
            const float f = fresnelDielectric(dot(known, m), eta_(si), cosThetaT, etaIt, etaTi);
            if (x < transmissionRate(w, front, f)) {
                direction = normalize(refractAbout(known, m, cosThetaT, etaTi));
                if (!(known.z * direction.z < 0)) return std::nullopt;
                return finishSmooth(si, known, direction, mode, etaIt);
            }
            direction = reflectAbout(known, m);
        }
        if (!(known.z * direction.z > 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (wEye.z == 0 || wLight.z == 0) return {};
        const Weights w = weights(si);
        const bool reflect = wEye.z * wLight.z > 0, front = wEye.z > 0;
        if (!(reflect && front) && !(w.bsdf > 0)) return {};
        const float relative = eta_(si);
        // Side of wLight over side of wEye
        const float eta = reflect ? 1.0f : front ? relative : 1.0f / relative;
        Vec3f m = wEye + wLight * eta;
        const float length2 = lengthSquared(m);
        if (!(length2 > 0)) return {};
        m *= (m.z < 0 ? -1.0f : 1.0f) / std::sqrt(length2);
        const float eyeM = dot(wEye, m), lightM = dot(wLight, m);
        if (!(eyeM * wEye.z > 0 && lightM * wLight.z > 0)) return {};  // a facet seen from behind

        const MicrofacetDistribution distribution = facets(si);
        const float d = distribution.d(m), f = fresnelDielectric(eyeM, relative);
        const float dg = d * distribution.g1(wEye, m) * distribution.g1(wLight, m) / std::abs(wEye.z);
        const float pdfEyeSide = distribution.visiblePdfOverCosine(wEye, m, d);
        const float pdfLightSide = distribution.visiblePdfOverCosine(wLight, m, d);
        const Rgb baseColor = baseColor_(si);
        if (!reflect) {
            // As in the rough dielectric; the square root is Burley's: light crosses two such surfaces.
            const float t = (1.0f - f) * std::abs(eyeM * lightM) / length2;
            const Rgb color(safeSqrt(baseColor.x), safeSqrt(baseColor.y), safeSqrt(baseColor.z));
            const float jacobian = std::abs(eyeM * lightM) / length2;
            return {color * (w.bsdf * t * dg),
                    probability(transmissionRate(w, front, f), w, front) * jacobian * eta * eta * pdfEyeSide,
                    probability(transmissionRate(w, !front, f), w, !front) * jacobian * pdfLightSide};
        }
        const float specular = 0.25f * probability(reflectionRate(w, front, f), w, front);
        BsdfEvaluation result;
        result.pdfLight = specular * pdfEyeSide;
        result.pdfEye = specular * pdfLightSide;
        if (!front) {
            result.value = Rgb(w.bsdf * f * 0.25f * dg);
            return result;
        }
        // Mitsuba switches the whole lobe off, metal included, where the indices match.
        if (f > 0) result.value = frontFresnel(si, w, baseColor, f, eyeM) * (0.25f * dg);
        addClearcoat(si, w, m, wEye, wLight, eyeM, result);
        addDiffuse(si, w, baseColor, wEye, wLight, eyeM, result);
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const Rgb base = baseColor_(si);
        const float metallic = metallic_(si), trans = specTrans_(si),
                    f = principled::reflectanceAtNormal(eta_.atLineD());
        const Rgb refracted(safeSqrt(base.x), safeSqrt(base.y), safeSqrt(base.z));
        const Rgb dielectric = Rgb(f) + lerp(trans, base, refracted) * (1.0f - f) + Rgb(0.05f * sheen_(si));
        const Rgb metal = schlickMean(base);
        return clampUnit(lerp(metallic, dielectric, metal) + Rgb(0.01f * clearcoat_(si)));
    }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }
    bool isTransmissive() const override { return !specTrans_.isZero(); }
    bool isDispersive() const override { return eta_.isDispersive(); }

  private:
    /// Shares of the major lobes: diffuse base, glass, metal and coat.
    struct Weights {
        float brdf, bsdf, metallic, clearcoat;
    };
    Weights weights(const SurfaceInteraction& si) const {
        const float metallic = metallic_(si), trans = specTrans_(si);
        return {(1.0f - metallic) * (1.0f - trans), (1.0f - metallic) * trans, metallic, clearcoat_(si)};
    }
    MicrofacetDistribution facets(const SurfaceInteraction& si) const {
        return principled::facets(roughness_(si), anisotropic_(si));
    }

    // How often sample() takes a lobe, up to totalRate(); `front` is the side of the known direction. From
    // inside only the two specular lobes exist. The sum of their rates does not depend on the Fresnel term f.
    float coatRate(const Weights& w) const { return 0.25f * w.clearcoat * clearcoatRate_; }
    float reflectionRate(const Weights& w, bool front, float f) const {
        return front ? specularRate_ * (1.0f - w.bsdf * (1.0f - f)) : f;
    }
    float transmissionRate(const Weights& w, bool front, float f) const {
        return front ? specularRate_ * w.bsdf * (1.0f - f) : 1.0f - f;
    }
    float totalRate(const Weights& w, bool front) const {
        return front ? specularRate_ + diffuseRate_ * w.brdf + coatRate(w) : 1.0f;
    }
    float probability(float rate, const Weights& w, bool front) const {
        return rate > 0 ? rate / totalRate(w, front) : 0.0f;
    }

    /// Fresnel term outside: the true dielectric one, tinted by Schlick's approximation, and metal.
    Rgb frontFresnel(const SurfaceInteraction& si, const Weights& w, const Rgb& baseColor, float f,
                     float cosine) const {
        const float specTint = specTint_(si), eta = eta_(si),
                    weight = schlickWeight(eta > 1 ? cosine : refractedCosine(cosine, eta));
        const auto schlick = [&](const Rgb& r0) { return lerp(weight, r0, Rgb(1.0f)); };
        Rgb result((1.0f - w.metallic) * (1.0f - specTint) * f);
        if (w.metallic > 0) result += schlick(baseColor) * w.metallic;
        if (specTint > 0)
            result += schlick(principled::tint(baseColor) * principled::reflectanceAtNormal(eta)) *
                      ((1.0f - w.metallic) * specTint);
        return result;
    }
    static float refractedCosine(float cosine, float eta) {
        return safeSqrt(1.0f - (1.0f - cosine * cosine) / sqr(eta));
    }

    void addClearcoat(const SurfaceInteraction& si, const Weights& w, const Vec3f& m, const Vec3f& wEye,
                      const Vec3f& wLight, float cosHalf, BsdfEvaluation& result) const {
        if (!(w.clearcoat > 0)) return;
        const Clearcoat coat(clearcoatGloss_(si));
        const float eta = eta_(si),
                    fresnel =
                        lerp(schlickWeight(eta > 1 ? cosHalf : refractedCosine(cosHalf, eta)), 0.04f, 1.0f);
        result.value += Rgb(0.25f * w.clearcoat * fresnel * coat.d(m) * Clearcoat::g1(wEye) *
                            Clearcoat::g1(wLight) * wLight.z);
        const float pdf = probability(coatRate(w), w, true) * coat.pdf(m) / (4.0f * cosHalf);
        result.pdfLight += pdf;
        result.pdfEye += pdf;
    }

    void addDiffuse(const SurfaceInteraction& si, const Weights& w, const Rgb& baseColor, const Vec3f& wEye,
                    const Vec3f& wLight, float cosHalf, BsdfEvaluation& result) const {
        if (w.brdf > 0) {
            const float shape =
                principled::diffuseShape(roughness_(si), flatness_(si), wEye.z, wLight.z, cosHalf);
            result.value += baseColor * (w.brdf * kInvPi * wLight.z * shape);
            const float p = probability(diffuseRate_ * w.brdf, w, true);
            result.pdfLight += p * warp::cosineHemispherePdf(wLight);
            result.pdfEye += p * warp::cosineHemispherePdf(wEye);
        }
        const float sheen = sheen_(si);
        if (sheen > 0 && w.metallic < 1) {
            const Rgb color = lerp(sheenTint_(si), Rgb(1.0f), principled::tint(baseColor));
            result.value += color * (sheen * (1.0f - w.metallic) * schlickWeight(cosHalf) * wLight.z);
        }
    }

    ColorParameter baseColor_;
    ScalarParameter roughness_, anisotropic_, metallic_, specTrans_, specTint_, sheen_, sheenTint_, flatness_,
        clearcoat_, clearcoatGloss_;
    RelativeIndex eta_;
    float diffuseRate_, specularRate_, clearcoatRate_;
};

}  // namespace

BsdfPtr makePrincipled(const PrincipledParameters& p) {
    if (p.eta && (!(p.eta->atLineD() > 0) || !std::isfinite(p.eta->atLineD())))
        throw Error("principled: eta is {}, expected a positive number", p.eta->atLineD());
    if (p.eta && p.eta->isDispersive() && p.eta->passesOne())
        throw Error("principled: the index of refraction is 1 at a wavelength, expected another number");
    if (!(p.specular >= 0 && p.specular <= 1))
        throw Error("principled: specular is {}, expected a number in [0, 1]", p.specular);
    for (const float rate :
         {p.diffuseReflectanceSamplingRate, p.mainSpecularSamplingRate, p.clearcoatSamplingRate})
        if (!(rate >= 0) || !std::isfinite(rate))
            throw Error("principled: a sampling rate is {}, expected a number that is not negative", rate);
    return std::make_shared<Principled>(p);
}

}  // namespace metrolux::core
