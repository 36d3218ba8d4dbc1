#include "scattering/dielectric.h"

#include "base/error.h"
#include "scattering/delta_pair.h"
#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class Dielectric final : public DeltaPair {
  public:
    explicit Dielectric(const DielectricParameters& p)
        : eta_(p.eta), reflectance_(p.specularReflectance, 1), transmittance_(p.specularTransmittance, 1) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f&) const override {
        if (known.z == 0) return std::nullopt;
        float cosThetaT, etaIt, etaTi;
        const float f = fresnelDielectric(known.z, eta_(si), cosThetaT, etaIt, etaTi);
        const Vec3f refraction = normalize(Vec3f(-etaTi * known.x, -etaTi * known.y, cosThetaT));
        return choose(known, mode, uLobe, reflectance_(si) * f, transmittance_(si) * (1 - f), refraction,
                      etaIt);
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        const float f = 0.5f * (fresnelDiffuseReflectance(eta_.atLineD()) +
                                fresnelDiffuseReflectance(1 / eta_.atLineD()));
        return clampUnit(lerp(std::clamp(f, 0.0f, 1.0f), transmittance_(si), reflectance_(si)));
    }
    bool isDispersive() const override { return eta_.isDispersive(); }

  private:
    RelativeIndex eta_;
    ColorParameter reflectance_, transmittance_;
};

}  // namespace

BsdfPtr makeDielectric(const DielectricParameters& parameters) {
    if (const float eta = parameters.eta.atLineD(); !(eta > 0) || !std::isfinite(eta))
        throw Error("dielectric: the relative index of refraction is {}, but must be positive", eta);
    return std::make_shared<Dielectric>(parameters);
}

}  // namespace metrolux::core
