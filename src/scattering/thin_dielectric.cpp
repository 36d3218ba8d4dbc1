#include "scattering/thin_dielectric.h"

#include "base/error.h"
#include "scattering/delta_pair.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class ThinDielectric final : public DeltaPair {
  public:
    explicit ThinDielectric(const ThinDielectricParameters& p)
        : eta_(p.eta), reflectance_(p.specularReflectance, 1), transmittance_(p.specularTransmittance, 1) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f&) const override {
        if (known.z == 0) return std::nullopt;
        const float f = sheetReflectance(fresnelDielectric(absCosTheta(known), eta_(si)));
        return choose(known, mode, uLobe, reflectance_(si) * f, transmittance_(si) * (1 - f), -known, 1);
    }

    bool isDispersive() const override { return eta_.isDispersive(); }
    bool hasNullLobe() const override { return true; }
    NullLobe nullLobe(const SurfaceInteraction& si, const Vec3f& w) const override {
        const float f = sheetReflectance(fresnelDielectric(absCosTheta(w), eta_(si)));
        const Rgb passed = transmittance_(si) * (1 - f);
        const float r = average(reflectance_(si) * f), t = average(passed);
        return {passed, t > 0 ? t / (r + t) : 0.0f};
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const float f = sheetReflectance(std::clamp(fresnelDiffuseReflectance(eta_.atLineD()), 0.0f, 1.0f));
        return clampUnit(lerp(f, transmittance_(si), reflectance_(si)));
    }

  private:
    /// R + TRT + TR^3T + ... = 2R / (1 + R) for T = 1 - R
    static float sheetReflectance(float r) { return 2 * r / (1 + r); }

    RelativeIndex eta_;
    ColorParameter reflectance_, transmittance_;
};

}  // namespace

BsdfPtr makeThinDielectric(const ThinDielectricParameters& parameters) {
    if (const float eta = parameters.eta.atLineD(); !(eta > 0) || !std::isfinite(eta))
        throw Error("thindielectric: the relative index of refraction is {}, but must be positive", eta);
    return std::make_shared<ThinDielectric>(parameters);
}

}  // namespace metrolux::core
