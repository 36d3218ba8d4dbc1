#include "scattering/blend.h"

#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class Blend final : public Bsdf {
  public:
    explicit Blend(const BlendParameters& p) : weight_(p.weight, 0.5f), first_(p.first), second_(p.second) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        const float w = weight(si);
        const bool second = uLobe < w;
        const float probability = second ? w : 1 - w;
        const float rescaled = std::min(second ? uLobe / w : (uLobe - w) / (1 - w), kOneMinusEpsilon);
        auto result = (second ? *second_ : *first_).sample(si, known, mode, rescaled, u);
        if (!result) return std::nullopt;
        // A smooth sample stands for both models; a delta lobe belongs to one of them.
        if (!result->delta) return finishSmooth(si, known, result->direction, mode, result->eta);
        result->pdfForward *= probability;
        result->pdfReverse *= probability;
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        const float w = weight(si);
        const BsdfEvaluation a = w < 1 ? first_->evaluate(si, wEye, wLight) : BsdfEvaluation{};
        const BsdfEvaluation b = w > 0 ? second_->evaluate(si, wEye, wLight) : BsdfEvaluation{};
        return {lerp(w, a.value, b.value), metrolux::core::lerp(w, a.pdfLight, b.pdfLight),
                metrolux::core::lerp(w, a.pdfEye, b.pdfEye)};
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        return lerp(weight(si), first_->albedo(si), second_->albedo(si));
    }
    bool hasSmoothLobe() const override { return first_->hasSmoothLobe() || second_->hasSmoothLobe(); }
    bool isNarrow(const SurfaceInteraction& si) const override {
        return first_->isNarrow(si) && second_->isNarrow(si);
    }
    bool hasDeltaLobe() const override { return first_->hasDeltaLobe() || second_->hasDeltaLobe(); }
    bool isTransmissive() const override { return first_->isTransmissive() || second_->isTransmissive(); }
    bool isDispersive() const override { return first_->isDispersive() || second_->isDispersive(); }

  private:
    float weight(const SurfaceInteraction& si) const { return std::clamp(weight_(si), 0.0f, 1.0f); }

    ScalarParameter weight_;
    BsdfPtr first_, second_;
};

}  // namespace

BsdfPtr makeBlend(const BlendParameters& parameters) { return std::make_shared<Blend>(parameters); }

}  // namespace metrolux::core
