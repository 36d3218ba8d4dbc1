#include "scattering/two_sided.h"

#include "base/error.h"

namespace metrolux::core {
namespace {

Vec3f mirrored(const Vec3f& v) { return {v.x, v.y, -v.z}; }

class TwoSided final : public Bsdf {
  public:
    explicit TwoSided(const TwoSidedParameters& p)
        : front_(p.front),
          back_(p.back ? p.back : p.front),
          smooth_(front_->hasSmoothLobe() || back_->hasSmoothLobe()) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        if (known.z > 0) return front_->sample(si, known, mode, uLobe, u);
        auto result = back_->sample(si, mirrored(known), mode, uLobe, u);
        if (result) result->direction = mirrored(result->direction);
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        if (!sameHemisphere(wEye, wLight)) return {};
        return wEye.z > 0 ? front_->evaluate(si, wEye, wLight)
                          : back_->evaluate(si, mirrored(wEye), mirrored(wLight));
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        return front_ == back_ ? front_->albedo(si) : (front_->albedo(si) + back_->albedo(si)) * 0.5f;
    }
    bool hasSmoothLobe() const override { return smooth_; }
    bool isNarrow(const SurfaceInteraction& si) const override {
        return front_->isNarrow(si) && back_->isNarrow(si);
    }
    bool hasDeltaLobe() const override { return front_->hasDeltaLobe() || back_->hasDeltaLobe(); }

  private:
    BsdfPtr front_, back_;
    bool smooth_;
};

}  // namespace

BsdfPtr makeTwoSided(const TwoSidedParameters& parameters) {
    if (parameters.front->isTransmissive() || (parameters.back && parameters.back->isTransmissive()))
        throw Error("twosided: a model that lets light pass cannot be nested");
    return std::make_shared<TwoSided>(parameters);
}

}  // namespace metrolux::core
