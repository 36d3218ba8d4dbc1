#include "scattering/coating.h"

#include "base/error.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"
#include "scattering/rough_interface.h"

namespace metrolux::core {
namespace {

class Coating final : public Bsdf {
  public:
    explicit Coating(const CoatingParameters& p)
        : eta_(p.eta),
          thickness_(p.thickness),
          sigmaA_(p.sigmaA, 0),
          specular_(p.specularReflectance, 1),
          base_(p.base) {
        if (p.alpha)
            rough_.emplace(p.distribution, p.alpha, p.eta, false);
        else if (p.facets)
            rough_.emplace(*p.facets, p.eta, false);
    }

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (known.z == 0) return std::nullopt;
        const Outside surface = outsideAt(si);
        const float specular = specularProbability(surface, si, known);
        if (uLobe < specular) return reflected(surface, si, known, mode, specular, u);
        const float rescaled = std::min((uLobe - specular) / (1 - specular), kOneMinusEpsilon);
        const Vec3f knownInside = inside(known);
        auto result = base_->sample(si, knownInside, mode, rescaled, u);
        if (!result) return std::nullopt;
        const auto direction = outside(result->direction);
        if (!direction || direction->z * known.z <= 0) return std::nullopt;
        if (!result->delta) return finishSmooth(si, known, *direction, mode);
        // A delta lobe of the base keeps its energy, but for what the layer takes away; its weight for
        // importance has the ratio of the cosines inside.
        result->weight *= transmittance(surface, known) * transmittance(surface, *direction) / (1 - specular);
        result->weight *= absorption(si, knownInside, result->direction);
        if (mode == TransportMode::Importance)
            result->weight *= absCosTheta(known) * absCosTheta(result->direction) /
                              (absCosTheta(*direction) * absCosTheta(knownInside));
        result->pdfForward *= 1 - specular;
        result->pdfReverse *= 1 - specularProbability(surface, si, *direction);
        result->direction = *direction;
        if (isBlack(result->weight)) return std::nullopt;
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z * wLight.z > 0)) return {};
        const Vec3f eye = inside(wEye), light = inside(wLight);
        const Outside surface = outsideAt(si);
        const float specularEye = specularProbability(surface, si, wEye),
                    specularLight = specularProbability(surface, si, wLight);
        BsdfEvaluation result = base_->evaluate(si, eye, light);
        // Solid angles inside over those outside.
        const float squeezeEye = wEye.z / (eta_ * eta_ * eye.z),
                    squeezeLight = wLight.z / (eta_ * eta_ * light.z);
        result.value *= transmittance(surface, wEye) * transmittance(surface, wLight) * squeezeLight;
        result.value *= absorption(si, eye, light);
        result.pdfLight *= (1 - specularEye) * squeezeLight;
        result.pdfEye *= (1 - specularLight) * squeezeEye;
        if (surface) addReflection(surface->facets, si, wEye, wLight, specularEye, specularLight, result);
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const float external = eta_ == 1 ? 0.0f : fresnelDiffuseReflectance(eta_);
        return clampUnit(specular_(si) * external + base_->albedo(si) * (1 - external));
    }
    bool hasSmoothLobe() const override { return rough_ || base_->hasSmoothLobe(); }
    bool hasDeltaLobe() const override { return !rough_ || base_->hasDeltaLobe(); }
    bool isNarrow(const SurfaceInteraction& si) const override { return !rough_ && base_->isNarrow(si); }

  private:
    using Outside = std::optional<RoughInterface::At>;  ///< nothing where it is smooth
    Outside outsideAt(const SurfaceInteraction& si) const {
        return rough_ ? Outside((*rough_)(si)) : std::nullopt;
    }
    float transmittance(const Outside& surface, const Vec3f& w) const {
        return surface ? surface->transmittance(absCosTheta(w)) : 1 - fresnelDielectric(absCosTheta(w), eta_);
    }

    /// In the layer, on the same side: Snell's law at the mean surface. Total reflection, of a layer that is
    /// optically thinner than the outside, has no transmittance.
    Vec3f inside(const Vec3f& w) const {
        const float sine2 = (1 - w.z * w.z) / (eta_ * eta_);
        const float cosine = std::max(safeSqrt(1 - sine2), 1e-4f);
        return normalize(Vec3f(w.x / eta_, w.y / eta_, std::copysign(cosine, w.z)));
    }
    /// The inverse; nothing where light is reflected back inside.
    std::optional<Vec3f> outside(const Vec3f& w) const {
        const float sine2 = (1 - w.z * w.z) * eta_ * eta_;
        if (!(sine2 < 1)) return std::nullopt;
        return normalize(Vec3f(w.x * eta_, w.y * eta_, std::copysign(std::sqrt(1 - sine2), w.z)));
    }

    Rgb absorption(const SurfaceInteraction& si, const Vec3f& a, const Vec3f& b) const {
        const float way = thickness_ * (1 / absCosTheta(a) + 1 / absCosTheta(b));
        const Rgb sigma = sigmaA_(si);
        return {std::exp(-sigma.x * way), std::exp(-sigma.y * way), std::exp(-sigma.z * way)};
    }

    /// Probability of the outer reflection, given one direction.
    float specularProbability(const Outside& surface, const SurfaceInteraction& si, const Vec3f& w) const {
        const float transmitted = transmittance(surface, w);
        const float specular = (1 - transmitted) * average(specular_(si));
        const float base = transmitted * average(base_->albedo(si));
        return specular > 0 ? std::min(specular / (specular + base), 0.999f) : 0.0f;
    }

    std::optional<BsdfSample> reflected(const Outside& surface, const SurfaceInteraction& si,
                                        const Vec3f& known, TransportMode mode, float probability,
                                        const Vec2f& u) const {
        if (surface) {
            const float side = known.z > 0 ? 1.0f : -1.0f;
            const Vec3f m = surface->facets.sampleVisible(known * side, u) * side;
            const Vec3f direction = reflectAbout(known, m);
            if (!(direction.z * known.z > 0)) return std::nullopt;
            return finishSmooth(si, known, direction, mode);
        }
        BsdfSample result;
        result.direction = {-known.x, -known.y, known.z};
        const Rgb energy = specular_(si) * (1 - transmittance(surface, known));
        if (isBlack(energy)) return std::nullopt;
        result.weight = deltaWeight(mode, energy, probability, known, result.direction, 1);
        result.pdfForward = result.pdfReverse = probability;
        result.delta = true;
        return result;
    }

    void addReflection(const MicrofacetDistribution& facets, const SurfaceInteraction& si, const Vec3f& wEye,
                       const Vec3f& wLight, float specularEye, float specularLight,
                       BsdfEvaluation& result) const {
        Vec3f m = normalize(wEye + wLight);
        if (m.z < 0) m = -m;
        const float d = facets.d(m);
        if (d == 0) return;
        const float fresnel = fresnelDielectric(absDot(wEye, m), eta_);
        const float g = facets.g1(wEye, m) * facets.g1(wLight, m);
        result.value += specular_(si) * (fresnel * d * g / (4 * absCosTheta(wEye)));
        result.pdfLight += 0.25f * specularEye * facets.visiblePdfOverCosine(wEye, m, d);
        result.pdfEye += 0.25f * specularLight * facets.visiblePdfOverCosine(wLight, m, d);
    }

    float eta_, thickness_;
    ColorParameter sigmaA_, specular_;
    BsdfPtr base_;
    std::optional<RoughInterface> rough_;
};

}  // namespace

BsdfPtr makeCoating(const CoatingParameters& p) {
    if (!(p.eta > 0) || !std::isfinite(p.eta))
        throw Error("coating: the ratio of the indices of refraction is {}, expected a positive number",
                    p.eta);
    if (!(p.thickness >= 0)) throw Error("coating: the thickness is {}, expected 0 or more", p.thickness);
    if (!p.base) throw Error("coating: there is no BSDF to be coated");
    if (p.base->isTransmissive())
        throw Error("coating: the BSDF below transmits light, expected an opaque one");
    return std::make_shared<Coating>(p);
}

}  // namespace metrolux::core
