#include "scattering/conductor.h"

#include "scattering/metal.h"

namespace metrolux::core {
namespace {

class Conductor final : public Bsdf {
  public:
    explicit Conductor(const ConductorParameters& p) : metal_(p.eta, p.k, p.specularReflectance) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float, const Vec2f&) const override {
        if (!(known.z > 0)) return std::nullopt;
        BsdfSample result;
        result.delta = true;
        result.direction = reflectLocal(known);
        result.pdfForward = result.pdfReverse = 1;
        const Rgb energy = metal_.reflectance(si, known.z);
        result.weight = deltaWeight(mode, energy, 1, known, result.direction, 1);
        if (isBlack(result.weight)) return std::nullopt;
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction&, const Vec3f&, const Vec3f&) const override {
        return {};
    }

    Rgb albedo(const SurfaceInteraction& si) const override { return metal_.albedo(si); }
    bool hasSmoothLobe() const override { return false; }
    bool hasDeltaLobe() const override { return true; }

  private:
    Metal metal_;
};

}  // namespace

BsdfPtr makeConductor(const ConductorParameters& parameters) {
    return std::make_shared<Conductor>(parameters);
}

}  // namespace metrolux::core
