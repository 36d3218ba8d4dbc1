#pragma once
/// Models that are nothing but one delta reflection and one delta transmission.

#include "scattering/bsdf.h"

namespace metrolux::core {

class DeltaPair : public Bsdf {
  public:
    BsdfEvaluation evaluate(const SurfaceInteraction&, const Vec3f&, const Vec3f&) const override {
        return {};
    }
    bool hasSmoothLobe() const override { return false; }
    bool hasDeltaLobe() const override { return true; }
    bool isTransmissive() const override { return true; }

  protected:
    /// Chooses between the lobes with the given energies in proportion to their means and makes the sample.
    /// Both ends of either lobe see the same energies, hence the same probability: Fresnel reflectance is
    /// that of both sides.
    static std::optional<BsdfSample> choose(const Vec3f& known, TransportMode mode, float uLobe,
                                            const Rgb& reflected, const Rgb& transmitted,
                                            const Vec3f& refraction, float eta) {
        const float r = average(reflected), t = average(transmitted);
        if (!(r + t > 0)) return std::nullopt;
        const bool reflects = uLobe * (r + t) < r;
        BsdfSample result;
        result.delta = true;
        result.transmitted = !reflects;
        result.direction = reflects ? reflectLocal(known) : refraction;
        result.eta = reflects ? 1.0f : eta;
        result.pdfForward = result.pdfReverse = (reflects ? r : t) / (r + t);
        if (!(result.pdfForward > 0) || result.direction.z == 0) return std::nullopt;
        result.weight = deltaWeight(mode, reflects ? reflected : transmitted, result.pdfForward, known,
                                    result.direction, result.eta);
        return result;
    }
};

}  // namespace metrolux::core
