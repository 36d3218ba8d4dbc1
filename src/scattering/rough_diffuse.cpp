#include "scattering/rough_diffuse.h"

#include "scattering/cosine_sampled.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

float cube(float x) { return x * x * x; }

class RoughDiffuse {
  public:
    explicit RoughDiffuse(const RoughDiffuseParameters& p)
        : reflectance_(p.reflectance, 0.5f), alpha_(p.alpha, 0.2f), fast_(p.fastApproximation) {}

    Rgb albedo(const SurfaceInteraction& si) const { return clampUnit(reflectance_(si)); }
    Rgb radiance(const SurfaceInteraction& si, const Vec3f& a, const Vec3f& b) const {
        const Rgb rho = albedo(si);
        const float sigma2 = 0.5f * sqr(std::max(alpha_(si), 0.0f));
        // The angle to the normal is larger of the one direction (theta1) than of the other (theta2).
        const float theta1 = std::acos(std::min(std::min(a.z, b.z), 1.0f)),
                    theta2 = std::acos(std::min(std::max(a.z, b.z), 1.0f));
        const float sines = safeSqrt(1 - a.z * a.z) * safeSqrt(1 - b.z * b.z);
        const float cosPhi = sines > 1e-6f ? std::clamp((a.x * b.x + a.y * b.y) / sines, -1.0f, 1.0f) : 0.0f;
        const float c1 = 1 - 0.5f * sigma2 / (sigma2 + 0.33f);
        const float c2 = 0.45f * sigma2 / (sigma2 + 0.09f);
        if (fast_) return rho * (c1 + c2 * std::max(cosPhi, 0.0f) * std::sin(theta1) * std::tan(theta2));
        const float inner = cosPhi >= 0 ? std::sin(theta1) : std::sin(theta1) - cube(2 * theta2 * kInvPi);
        const float c3 = 0.125f * sigma2 / (sigma2 + 0.09f) * sqr(4 * theta1 * theta2 * kInvPi * kInvPi);
        const float direct = c1 + cosPhi * c2 * inner * std::tan(theta2) +
                             (1 - std::abs(cosPhi)) * c3 * std::tan(0.5f * (theta1 + theta2));
        const float twice = 0.17f * sigma2 / (sigma2 + 0.13f) * (1 - cosPhi * sqr(2 * theta2 * kInvPi));
        return rho * std::max(direct, 0.0f) + rho * rho * twice;
    }

  private:
    ColorParameter reflectance_;
    ScalarParameter alpha_;
    bool fast_;
};

}  // namespace

BsdfPtr makeRoughDiffuse(const RoughDiffuseParameters& parameters) {
    return std::make_shared<CosineSampled<RoughDiffuse>>(RoughDiffuse(parameters));
}

}  // namespace metrolux::core
