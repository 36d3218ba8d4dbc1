#include "scattering/phong.h"

#include "base/warp.h"
#include "scattering/diffuse_specular.h"

namespace metrolux::core {
namespace {

class Phong final : public Bsdf {
  public:
    explicit Phong(const PhongParameters& p)
        : colors_(p.diffuseReflectance, 0.5f, p.specularReflectance, 0.2f), exponent_(p.exponent, 30) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        if (uLobe >= colors_.specularProbability())
            return finishSmooth(si, known, warp::squareToCosineHemisphere(u), mode);
        const float cosine = std::pow(1.0f - u.y, 1.0f / (exponent(si) + 1.0f));
        const float sine = safeSqrt(1.0f - cosine * cosine), phi = 2.0f * kPi * u.x;
        const Vec3f direction = Frame::fromNormal(reflectLocal(known))
                                    .toWorld({sine * std::cos(phi), sine * std::sin(phi), cosine});
        if (!(direction.z > 0)) return std::nullopt;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        const float p = colors_.specularProbability();
        BsdfEvaluation result{colors_.diffuse(si) * (kInvPi * wLight.z),
                              (1.0f - p) * warp::cosineHemispherePdf(wLight),
                              (1.0f - p) * warp::cosineHemispherePdf(wEye)};
        const float cosine = std::min(1.0f, dot(wLight, reflectLocal(wEye)));
        if (!(cosine > 0)) return result;
        // [Lafortune & Willems 1994, eq. 10]; the lobe is symmetric, so both densities are the same
        const float n = exponent(si), lobe = std::pow(cosine, n) * (0.5f * kInvPi);
        result.value += colors_.specular(si) * ((n + 2.0f) * lobe * wLight.z);
        result.pdfLight += p * (n + 1.0f) * lobe;
        result.pdfEye += p * (n + 1.0f) * lobe;
        return result;
    }

    Rgb albedo(const SurfaceInteraction& si) const override { return colors_.sum(si); }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }

  private:
    float exponent(const SurfaceInteraction& si) const { return std::max(0.0f, exponent_(si)); }

    DiffuseSpecular colors_;
    ScalarParameter exponent_;
};

}  // namespace

BsdfPtr makePhong(const PhongParameters& parameters) { return std::make_shared<Phong>(parameters); }

}  // namespace metrolux::core
