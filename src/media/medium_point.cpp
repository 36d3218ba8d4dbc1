#include "media/medium_point.h"

#include "base/frame.h"
#include "scattering/bsdf.h"

namespace metrolux::core {
namespace {

class MediumScattering final : public Bsdf {
  public:
    explicit MediumScattering(MediumPtr medium) : medium_(std::move(medium)) {}

    std::optional<BsdfSample> sample(const SurfaceInteraction& si, const Vec3f& known, TransportMode,
                                     float uLobe, const Vec2f& u) const override {
        const PhaseFunction::Sample s = medium_->phase().sample(si.p, uLobe, u.x);
        const Rgb sigma = medium_->scattering(si.p);
        if (!(s.density > 0) || isBlack(sigma)) return std::nullopt;
        const Frame frame = Frame::fromNormal(-known);
        const float sine = safeSqrt(1 - s.cosine * s.cosine), phi = 2 * kPi * u.y;
        BsdfSample result;
        result.direction = normalize(frame.toWorld({sine * std::cos(phi), sine * std::sin(phi), s.cosine}));
        result.weight = sigma;
        result.pdfForward = result.pdfReverse = s.density;
        return result;
    }
    BsdfEvaluation evaluate(const SurfaceInteraction& si, const Vec3f& wEye,
                            const Vec3f& wLight) const override {
        const float density = medium_->phase().evaluate(si.p, std::clamp(-dot(wEye, wLight), -1.0f, 1.0f));
        return {medium_->scattering(si.p) * density, density, density};
    }
    Rgb albedo(const SurfaceInteraction& si) const override {
        const Rgb extinction = medium_->extinction(si.p), scattering = medium_->scattering(si.p);
        Rgb result(0.0f);
        for (int c = 0; c < 3; ++c)
            if (extinction[c] > 0) result[c] = std::min(scattering[c] / extinction[c], 1.0f);
        return result;
    }
    bool hasSmoothLobe() const override { return medium_->scatters(); }
    bool hasDeltaLobe() const override { return false; }
    bool isTransmissive() const override { return true; }
    Rgb stopDensity(const SurfaceInteraction& si, const Vec3f&) const override {
        return medium_->extinction(si.p);
    }

  private:
    MediumPtr medium_;
};

class MediumPoint final : public Shape {
  public:
    explicit MediumPoint(MediumPtr medium) {
        bsdf = std::make_shared<MediumScattering>(std::move(medium));
        id = "medium";
    }
    // It has no surface.
    float area() const override { return 0; }
    ShapeSample sampleArea(const Vec2f&) const override { return {}; }
    void bounds(Vec3f& lower, Vec3f& upper) const override { lower = upper = Vec3f(0.0f); }
    Partials partialsAt(const SurfaceInteraction&) const override { return {}; }
};

}  // namespace

ShapePtr makeMediumPoint(MediumPtr medium) { return std::make_shared<MediumPoint>(std::move(medium)); }

}  // namespace metrolux::core
