#include "scattering/null_bsdf.h"

namespace metrolux::core {
namespace {

class NullBsdf final : public Bsdf {
  public:
    std::optional<BsdfSample> sample(const SurfaceInteraction&, const Vec3f& known, TransportMode, float,
                                     const Vec2f&) const override {
        if (known.z == 0) return std::nullopt;
        return passThrough(known, Rgb(1.0f), 1);
    }
    BsdfEvaluation evaluate(const SurfaceInteraction&, const Vec3f&, const Vec3f&) const override {
        return {};
    }
    Rgb albedo(const SurfaceInteraction&) const override { return Rgb(1.0f); }
    bool hasSmoothLobe() const override { return false; }
    bool hasDeltaLobe() const override { return true; }
    bool isTransmissive() const override { return true; }
    bool hasNullLobe() const override { return true; }
    NullLobe nullLobe(const SurfaceInteraction&, const Vec3f&) const override { return {Rgb(1.0f), 1}; }
};

}  // namespace

BsdfPtr makeNullBsdf() { return std::make_shared<NullBsdf>(); }
bool isNullBsdf(const Bsdf& bsdf) { return dynamic_cast<const NullBsdf*>(&bsdf) != nullptr; }

BsdfSample passThrough(const Vec3f& known, const Rgb& energy, float probability) {
    BsdfSample result;
    result.direction = -known;
    result.weight = energy * (1.0f / probability);  // the cosines of the two ends are equal
    result.pdfForward = result.pdfReverse = probability;
    result.delta = result.transmitted = true;
    return result;
}

}  // namespace metrolux::core
