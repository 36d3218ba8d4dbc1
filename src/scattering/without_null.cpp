#include "scattering/without_null.h"

#include "scattering/null_bsdf.h"

namespace metrolux::core {
namespace {

/// The density of a path that stops here and is scattered has to be that of one that is scattered by the
/// whole model: stopDensity() has as a factor what the densities of directions are divided by.
class WithoutNull final : public Bsdf {
  public:
    explicit WithoutNull(BsdfPtr nested) : nested_(std::move(nested)) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        const float stop = stopProbability(si, known);
        if (!(stop > 0)) return std::nullopt;
        std::optional<BsdfSample> s =
            nested_->sample(si, known, mode, std::min(uLobe * stop, kOneMinusEpsilon), u);
        if (!s) return s;
        // Rounding may have picked the lobe that is left out.
        if (s->delta && s->transmitted && s->direction == -known) return std::nullopt;
        const float stopReverse = stopProbability(si, s->direction);
        if (!(stopReverse > 0)) return std::nullopt;
        s->weight *= stop;
        s->pdfForward /= stop;
        s->pdfReverse /= stopReverse;
        return s;
    }
    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        const float stopEye = stopProbability(si, wEye), stopLight = stopProbability(si, wLight);
        if (!(stopEye > 0 && stopLight > 0)) return {};
        const BsdfEvaluation e = nested_->evaluate(si, wEye, wLight);
        return {e.value, e.pdfLight / stopEye, e.pdfEye / stopLight};
    }
    Rgb albedo(const SurfaceInteraction& si) const override { return nested_->albedo(si); }
    bool hasSmoothLobe() const override { return nested_->hasSmoothLobe(); }
    bool hasDeltaLobe() const override { return nested_->hasDeltaLobe(); }
    bool isNarrow(const SurfaceInteraction& si) const override { return nested_->isNarrow(si); }
    bool isTransmissive() const override { return true; }
    bool isDispersive() const override { return nested_->isDispersive(); }
    bool hasNullLobe() const override { return true; }
    NullLobe nullLobe(const SurfaceInteraction& si, const Vec3f& w) const override {
        return nested_->nullLobe(si, w);
    }
    Rgb stopDensity(const SurfaceInteraction& si, const Vec3f& w) const override {
        return Rgb(stopProbability(si, w));
    }

  private:
    float stopProbability(const SurfaceInteraction& si, const Vec3f& w) const {
        return 1 - nested_->nullLobe(si, w).probability;
    }
    BsdfPtr nested_;
};

}  // namespace

BsdfPtr withoutNull(const BsdfPtr& bsdf) {
    const bool nothingElse = isNullBsdf(*bsdf);
    if (!bsdf->hasNullLobe() || nothingElse || dynamic_cast<const WithoutNull*>(bsdf.get())) return bsdf;
    return std::make_shared<WithoutNull>(bsdf);
}

}  // namespace metrolux::core
