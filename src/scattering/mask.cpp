#include "scattering/mask.h"

#include "scattering/null_bsdf.h"
#include "scattering/parameter.h"

namespace metrolux::core {
namespace {

class Mask final : public Bsdf {
  public:
    explicit Mask(const MaskParameters& p) : opacity_(p.opacity, 0.5f), nested_(p.nested) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode mode,
                                     float uLobe, const Vec2f& u) const override {
        const float o = opacity(si);
        if (uLobe >= o) {
            if (known.z == 0) return std::nullopt;
            return passThrough(known, Rgb(1 - o), 1 - o);
        }
        auto result = nested_->sample(si, known, mode, std::min(uLobe / o, kOneMinusEpsilon), u);
        if (!result) return std::nullopt;
        result->pdfForward *= o;  // value and density have the same factor: the weight stays
        result->pdfReverse *= o;
        return result;
    }

    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        const float o = opacity(si);
        if (o == 0) return {};
        const BsdfEvaluation e = nested_->evaluate(si, wEye, wLight);
        return {e.value * o, e.pdfLight * o, e.pdfEye * o};
    }

    Rgb albedo(const SurfaceInteraction& si) const override {
        return lerp(opacity(si), Rgb(1.0f), nested_->albedo(si));
    }
    bool hasSmoothLobe() const override { return nested_->hasSmoothLobe(); }
    bool isNarrow(const SurfaceInteraction& si) const override { return nested_->isNarrow(si); }
    bool hasDeltaLobe() const override { return true; }
    bool isTransmissive() const override { return true; }
    bool isDispersive() const override { return nested_->isDispersive(); }
    bool hasNullLobe() const override { return true; }
    NullLobe nullLobe(const SurfaceInteraction& si, const Vec3f&) const override {
        const float o = opacity(si);
        return {Rgb(1 - o), 1 - o};
    }

  private:
    float opacity(const SurfaceInteraction& si) const { return std::clamp(opacity_(si), 0.0f, 1.0f); }

    ScalarParameter opacity_;
    BsdfPtr nested_;
};

}  // namespace

BsdfPtr makeMask(const MaskParameters& parameters) { return std::make_shared<Mask>(parameters); }

}  // namespace metrolux::core
