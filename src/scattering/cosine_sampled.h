#pragma once
#include "base/warp.h"
#include "scattering/bsdf.h"

namespace metrolux::core {

/// A diffuse reflector of the normal's side, whose directions are sampled by their cosine. `Model` has
/// Rgb albedo(si) and Rgb radiance(si, wEye, wLight): pi f, what a Lambertian surface of reflectance 1 has
/// as 1. The model is a member: as a base class with final functions (CRTP) GCC 12 at -O3 compiles evaluate()
/// to nothing.
template <class Model>
class CosineSampled final : public Bsdf {
  public:
    explicit CosineSampled(Model model) : model_(std::move(model)) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float, const Vec2f& u) const override {
        if (!(known.z > 0)) return std::nullopt;
        return finishSmooth(si, known, warp::squareToCosineHemisphere(u), mode);
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!(wEye.z > 0 && wLight.z > 0)) return {};
        return {model_.radiance(si, wEye, wLight) * (kInvPi * wLight.z), warp::cosineHemispherePdf(wLight),
                warp::cosineHemispherePdf(wEye)};
    }

    Rgb albedo(const SurfaceInteraction& si) const override { return model_.albedo(si); }
    bool hasSmoothLobe() const override { return true; }
    bool hasDeltaLobe() const override { return false; }

  private:
    Model model_;
};

}  // namespace metrolux::core
