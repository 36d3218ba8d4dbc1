#include "scattering/ward.h"

#include "base/warp.h"
#include "scattering/diffuse_specular.h"
#include "scattering/microfacet.h"

namespace metrolux::core {
namespace {

class Ward final : public Bsdf {
  public:
    explicit Ward(const WardParameters& p)
        : variant_(p.variant),
          colors_(p.diffuseReflectance, 0.5f, p.specularReflectance, 0.2f),
          alphaU_(p.alphaU, 0.1f),
          alphaV_(p.alphaV, 0.1f) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        if (uLobe >= colors_.specularProbability())
            return finishSmooth(si, known, warp::squareToCosineHemisphere(u), mode);
        // Half vectors with Gaussian slopes [Walter 2005, Notes on the Ward BRDF]
        const auto [a, b] = alpha(si);
        const float r = std::sqrt(-std::log(1.0f - u.x)), phi = 2.0f * kPi * u.y;
        const Vec3f h = normalize(Vec3f(a * r * std::cos(phi), b * r * std::sin(phi), 1.0f));
        const Vec3f direction = reflectAbout(known, h);
        if (!(direction.z > 0 && dot(known, h) > 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const float p = colors_.specularProbability();
        BsdfEvaluation result{colors_.diffuse(si) * (kInvPi * wLight.z),
                              (1.0f - p) * warp::cosineHemispherePdf(wLight),
                              (1.0f - p) * warp::cosineHemispherePdf(wEye)};
        const auto [a, b] = alpha(si);
        const Vec3f h = normalize(wEye + wLight);
        const float gauss = std::exp(-(sqr(h.x / a) + sqr(h.y / b)) / (h.z * h.z)) / (4.0f * kPi * a * b);
        const float cosine = dot(wEye, h);
        if (!(gauss > 0 && cosine > 0)) return result;
        const float f = gauss * normalization(wEye.z, wLight.z, h.z, cosine);
        const float pdf = gauss / (cosine * h.z * h.z * h.z);
        // So grazing that a float cannot hold it: the specular lobe is cut off in value and density.
        if (!(f * wLight.z < kInfinity && f < kInfinity && pdf < kInfinity)) return result;
        if (f > 1e-10f) result.value += colors_.specular(si) * (f * wLight.z);  // 0.6 drops smaller values
        result.pdfLight += p * pdf;
        result.pdfEye += p * pdf;
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override { return colors_.sum(si); }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }

  private:
    /// What follows the Gaussian, 1 / (4 pi a b) apart, in terms of the unit half vector.
    float normalization(float cosEye, float cosLight, float cosHalf, float cosine) const {
        switch (variant_) {
            case WardVariant::Ward:
                return 1.0f / std::sqrt(cosEye * cosLight);
            case WardVariant::WardDuer:
                return 1.0f / (cosEye * cosLight);
            case WardVariant::Balanced:
                break;
        }
        return 1.0f / sqr(cosine * cosHalf * cosHalf);  // with |wEye + wLight| = 2 cosine
    }

    std::pair<float, float> alpha(const SurfaceInteraction& si) const {
        return {std::max(MicrofacetDistribution::kMinAlpha, alphaU_(si)),
                std::max(MicrofacetDistribution::kMinAlpha, alphaV_(si))};
    }

    WardVariant variant_;
    DiffuseSpecular colors_;
    ScalarParameter alphaU_, alphaV_;
};

}  // namespace

BsdfPtr makeWard(const WardParameters& parameters) { return std::make_shared<Ward>(parameters); }

}  // namespace metrolux::core
