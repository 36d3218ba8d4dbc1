#include "base/error.h"
#include "base/warp.h"
#include "endpoint/lights.h"
#include "endpoint/lights/emission.h"
#include "endpoint/lights/texture_table.h"

namespace metrolux::core {

namespace {

class SpotLight final : public Light {
  public:
    explicit SpotLight(const SpotLightParameters& p)
        : position_(p.toWorld.point(Vec3f(0.0f))),
          axes_(localAxes(p.toWorld)),
          intensity_(p.intensity),
          cutoff_(radians(p.cutoffAngle)),
          beam_(radians(p.beamWidth)),
          texture_(p.texture) {
        requireEmission(intensity_, "spot");
        if (!(p.cutoffAngle > 0 && p.cutoffAngle <= 180))
            throw Error("spot light: the cutoff angle must be in (0, 180] degrees, found {}", p.cutoffAngle);
        if (!(p.beamWidth >= 0 && p.beamWidth <= p.cutoffAngle))
            throw Error("spot light: the beam width must be between 0 and the cutoff angle {}, found {}",
                        p.cutoffAngle, p.beamWidth);
        if (texture_ && !(p.cutoffAngle < 90))
            throw Error("spot light: a projected texture needs a cutoff angle below 90 degrees, found {}",
                        p.cutoffAngle);
        oneMinusCosCutoff_ = 2 * sqr(std::sin(0.5f * cutoff_));
        tanCutoff_ = std::tan(cutoff_);
    }

    float power() const override {
        // Integral of the falloff over the cone: 1 within the beam, then linear in the angle.
        const double c = cutoff_, b = beam_, inner = 1 - std::cos(b);
        const double ramp = c > b ? (std::sin(c) - std::sin(b)) / (c - b) : std::cos(b);
        const double integral = 2 * std::numbers::pi * (inner + std::cos(b) - ramp);
        const Rgb mean = texture_ ? intensity_ * texture_->mean() : intensity_;
        return static_cast<float>(integral) * std::max(luminance(mean), 0.0f);
    }
    std::optional<LightBounds> bounds() const override {
        const float mean = power() * warp::uniformConePdf(std::max(oneMinusCosCutoff_, 1e-30f));
        return LightBounds{position_, position_, {axes_.n, 1 - oneMinusCosCutoff_}, 1, mean};
    }
    bool isDelta() const override { return true; }

    std::optional<EndpointRay> sampleRay(const Vec2f&, const Vec2f& uDirection) const override {
        const Vec3f local = warp::squareToCone(uDirection, oneMinusCosCutoff_);
        const Rgb value = intensity(local);
        if (isBlack(value)) return std::nullopt;
        EndpointRay ray;
        ray.origin = position_;
        ray.direction = normalize(axes_.toWorld(local));
        ray.pdfDirection = warp::uniformConePdf(oneMinusCosCutoff_);
        ray.weight = value * (1.0f / ray.pdfDirection);
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f&) const override {
        std::optional<EndpointConnection> c = connectionToPoint(position_, x);
        if (!c) return std::nullopt;
        const Rgb value = intensity(axes_.toLocal(-c->wi));
        if (isBlack(value)) return std::nullopt;
        c->value = value * (1.0f / sqr(c->distance));
        c->pdfDirection = warp::uniformConePdf(oneMinusCosCutoff_);
        return c;
    }

  protected:
    void scaleEmission(float factor) override { intensity_ *= factor; }

  private:
    Rgb intensity(const Vec3f& local) const {
        const float angle = std::atan2(std::sqrt(local.x * local.x + local.y * local.y), local.z);
        if (!(angle < cutoff_)) return Rgb(0.0f);
        const float falloff = angle <= beam_ ? 1.0f : (cutoff_ - angle) / (cutoff_ - beam_);
        if (!texture_) return intensity_ * falloff;
        const float scale = 0.5f / (local.z * tanCutoff_);
        return intensity_ * textureAt(*texture_, {0.5f + local.x * scale, 0.5f + local.y * scale}) * falloff;
    }

    Vec3f position_;
    Frame axes_;
    Rgb intensity_;
    float cutoff_, beam_;
    TexturePtr texture_;
    float oneMinusCosCutoff_ = 0, tanCutoff_ = 0;
};

}  // namespace

LightPtr makeSpotLight(const SpotLightParameters& parameters) {
    return std::make_shared<SpotLight>(parameters);
}

}  // namespace metrolux::core
