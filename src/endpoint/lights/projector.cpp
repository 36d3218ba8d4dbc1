#include "base/error.h"
#include "endpoint/lights.h"
#include "endpoint/lights/emission.h"
#include "endpoint/lights/texture_table.h"

namespace metrolux::core {

namespace {

/// On the plane z = 1 the irradiance is pi * scale * texture, so the intensity toward a direction is that
/// over cos^3.
class Projector final : public Light {
  public:
    explicit Projector(const ProjectorParameters& p)
        : position_(p.toWorld.point(Vec3f(0.0f))),
          axes_(localAxes(p.toWorld)),
          texture_(p.irradiance),
          scale_(p.scale),
          halfWidth_(p.tanHalfFovX),
          halfHeight_(p.tanHalfFovX / p.aspect) {
        if (!texture_) throw Error("projector: the irradiance texture is missing");
        if (!(scale_ >= 0) || !std::isfinite(scale_))
            throw Error("projector: scale {} must be finite and not negative", scale_);
        if (!(halfWidth_ > 0) || !std::isfinite(halfWidth_) || !(halfHeight_ > 0) ||
            !std::isfinite(halfHeight_))
            throw Error("projector: the field of view must be between 0 and 180 degrees");
        table_ = luminanceTable(*texture_);
    }

    float power() const override {
        return std::max(luminance(texture_->mean()), 0.0f) * scale_ * kPi * planeArea();
    }
    std::optional<LightBounds> bounds() const override {
        const float toCorner = std::sqrt(1 + sqr(halfWidth_) + sqr(halfHeight_));
        // On the plane z = 1 the intensity along the axis is the irradiance.
        return LightBounds{position_, position_, {axes_.n, 1 / toCorner}, 1, power() / planeArea()};
    }
    bool isDelta() const override { return true; }

    std::optional<EndpointRay> sampleRay(const Vec2f&, const Vec2f& uDirection) const override {
        float pdfUv = 0;
        const Vec2f uv = table_.sample(uDirection, pdfUv);
        const Vec3f local = normalize(Vec3f((1 - 2 * uv.x) * halfWidth_, (1 - 2 * uv.y) * halfHeight_, 1));
        EndpointRay ray;
        ray.origin = position_;
        ray.direction = normalize(axes_.toWorld(local));
        const Rgb value = intensity(local, uv);
        ray.pdfDirection = pdfDirection(local, uv);
        if (isBlack(value) || !(ray.pdfDirection > 0)) return std::nullopt;
        ray.weight = value * (1.0f / ray.pdfDirection);
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f&) const override {
        std::optional<EndpointConnection> c = connectionToPoint(position_, x);
        if (!c) return std::nullopt;
        const Vec3f local = axes_.toLocal(-c->wi);
        if (!(local.z > 0)) return std::nullopt;
        const Vec2f uv(0.5f - 0.5f * local.x / (local.z * halfWidth_),
                       0.5f - 0.5f * local.y / (local.z * halfHeight_));
        if (!(uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1)) return std::nullopt;
        const Rgb value = intensity(local, uv);
        if (isBlack(value)) return std::nullopt;
        c->value = value * (1.0f / sqr(c->distance));
        c->pdfDirection = pdfDirection(local, uv);
        return c;
    }

  protected:
    void scaleEmission(float factor) override { scale_ *= factor; }

  private:
    float planeArea() const { return 4 * halfWidth_ * halfHeight_; }
    float pdfDirection(const Vec3f& local, const Vec2f& uv) const {
        return table_.pdf(uv) / (planeArea() * local.z * local.z * local.z);
    }
    Rgb intensity(const Vec3f& local, const Vec2f& uv) const {
        return textureAt(*texture_, uv) * (kPi * scale_ / (local.z * local.z * local.z));
    }

    Vec3f position_;
    Frame axes_;
    TexturePtr texture_;
    float scale_, halfWidth_, halfHeight_;
    Distribution2D table_;
};

}  // namespace

LightPtr makeProjector(const ProjectorParameters& parameters) {
    return std::make_shared<Projector>(parameters);
}

}  // namespace metrolux::core
