#include "scattering/diffuse_transmitter.h"

#include "base/warp.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class DiffuseTransmitter final : public Bsdf {
  public:
    explicit DiffuseTransmitter(const DiffuseTransmitterParameters& p)
        : transmittance_(p.transmittance, 0.5f) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float, const Vec2f& u) const override {
        Vec3f direction = warp::squareToCosineHemisphere(u);
        if (known.z > 0) direction.z = -direction.z;
        return finishSmooth(si, known, direction, mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z * wLight.z < 0)) return {};
        const float cosLight = absCosTheta(wLight), cosEye = absCosTheta(wEye);
        return {albedo(si) * (kInvPi * cosLight), kInvPi * cosLight, kInvPi * cosEye};
    }

    Rgb albedo(const SurfaceInteraction& si) const override { return clampUnit(transmittance_(si)); }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }
    bool isTransmissive() const override { return true; }

  private:
    ColorParameter transmittance_;
};

}  // namespace

BsdfPtr makeDiffuseTransmitter(const DiffuseTransmitterParameters& parameters) {
    return std::make_shared<DiffuseTransmitter>(parameters);
}

}  // namespace metrolux::core
