#include "scattering/diffuse.h"

#include "base/warp.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class Diffuse final : public Bsdf {
  public:
    explicit Diffuse(const DiffuseParameters& parameters) : reflectance_(parameters.reflectance, 0.5f) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        return finishSmooth(si, known, warp::squareToCosineHemisphere(u), mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        return {albedo(si) * (kInvPi * wLight.z), warp::cosineHemispherePdf(wLight),
                warp::cosineHemispherePdf(wEye)};
    }

    Rgb albedo(const SurfaceInteraction& si) const override { return clampUnit(reflectance_(si)); }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }

  private:
    ColorParameter reflectance_;
};

}  // namespace

BsdfPtr makeDiffuse(const DiffuseParameters& parameters) { return std::make_shared<Diffuse>(parameters); }

}  // namespace metrolux::core
