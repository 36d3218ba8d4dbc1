#include "base/warp.h"
#include "endpoint/lights.h"
#include "endpoint/lights/emission.h"

namespace metrolux::core {

namespace {

class PointLight final : public Light {
  public:
    explicit PointLight(const PointLightParameters& p) : position_(p.position), intensity_(p.intensity) {
        requireEmission(intensity_, "point");
    }

    float power() const override { return luminance(intensity_) * (4 * kPi); }
    std::optional<LightBounds> bounds() const override {
        return LightBounds{position_, position_, {}, 1, luminance(intensity_)};
    }
    bool isDelta() const override { return true; }

    std::optional<EndpointRay> sampleRay(const Vec2f&, const Vec2f& uDirection) const override {
        EndpointRay ray;
        ray.origin = position_;
        ray.direction = normalize(warp::squareToSphere(uDirection));
        ray.pdfDirection = warp::kUniformSpherePdf;
        ray.weight = intensity_ * (4 * kPi);
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f&) const override {
        std::optional<EndpointConnection> c = connectionToPoint(position_, x);
        if (!c || isBlack(intensity_)) return std::nullopt;
        c->value = intensity_ * (1.0f / sqr(c->distance));
        c->pdfDirection = warp::kUniformSpherePdf;
        return c;
    }

  protected:
    void scaleEmission(float factor) override { intensity_ *= factor; }

  private:
    Vec3f position_;
    Rgb intensity_;
};

}  // namespace

LightPtr makePointLight(const PointLightParameters& parameters) {
    return std::make_shared<PointLight>(parameters);
}

}  // namespace metrolux::core
