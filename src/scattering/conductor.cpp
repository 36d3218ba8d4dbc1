#include "scattering/conductor.h"

#include "scattering/fresnel.h"
#include "scattering/parameter.h"

namespace metrolux {
namespace {

class Conductor final : public Bsdf {
  public:
    explicit Conductor(const ConductorParameters& p)
        : eta_(p.eta, 0), k_(p.k, 1), reflectance_(p.specularReflectance, 1) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float, const Vec2f&) const override {
        if (!(known.z > 0)) return std::nullopt;
        BsdfSample result;
        result.delta = true;
        result.direction = reflectLocal(known);
        result.pdfForward = result.pdfReverse = 1;
        const Rgb energy = reflectance_(si) * fresnelConductor(known.z, eta_(si), k_(si));
        result.weight = deltaWeight(mode, energy, 1, known, result.direction, 1);
        if (isBlack(result.weight)) return std::nullopt;
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction&, const Vec3f&, const Vec3f&) const override {
        return {};
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        // Hemispherical mean of Schlick's approximation: F0 + (1 - F0) / 21
        const Rgb normalIncidence = fresnelConductor(1, eta_(si), k_(si));
        return clampUnit(reflectance_(si) * (normalIncidence * (20.0f / 21.0f) + Rgb(1.0f / 21.0f)));
    }
    bool hasSmoothLobe() const override { return false; }
    bool hasDeltaLobe() const override { return true; }

  private:
    ColorParameter eta_, k_, reflectance_;
};

}  // namespace

BsdfPtr makeConductor(const ConductorParameters& parameters) {
    return std::make_shared<Conductor>(parameters);
}

}  // namespace metrolux
