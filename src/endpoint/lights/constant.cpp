#include "endpoint/lights.h"
#include "endpoint/lights/infinite.h"

namespace metrolux::core {

namespace {

class ConstantLight final : public InfiniteLight {
  public:
    explicit ConstantLight(const ConstantLightParameters& p) : radiance_(p.radiance) {
        requireEmission(radiance_, "constant");
    }

    LightPtr copy() const override { return std::make_shared<ConstantLight>(*this); }
    float power() const override { return luminance(radiance_) * (4 * kPi) * diskArea(); }
    bool isDelta() const override { return false; }
    bool isEnvironment() const override { return true; }
    Rgb environmentRadiance(const Vec3f&) const override { return radiance_; }

    EndpointDensities environmentDensities(const Vec3f&, const Vec3f&) const override {
        return {warp::kUniformSpherePdf, diskPdf(), warp::kUniformSpherePdf, 1};
    }

    std::optional<EndpointRay> sampleRay(const Vec2f& uPosition, const Vec2f& uDirection) const override {
        EndpointRay ray;
        ray.direction = normalize(warp::squareToSphere(uDirection));
        ray.origin = diskPoint(ray.direction, uPosition);
        ray.pdfPosition = diskPdf();
        ray.pdfDirection = warp::kUniformSpherePdf;
        ray.weight = radiance_ * (4 * kPi * diskArea());
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f& u) const override {
        if (isBlack(radiance_)) return std::nullopt;
        EndpointConnection c = connectionAlong(x, normalize(warp::squareToSphere(u)));
        c.value = radiance_ * (4 * kPi);
        c.pdf = c.pdfDirection = warp::kUniformSpherePdf;
        return c;
    }

  protected:
    void scaleEmission(float factor) override { radiance_ *= factor; }

  private:
    Rgb radiance_;
};

}  // namespace

LightPtr makeConstantLight(const ConstantLightParameters& parameters) {
    return std::make_shared<ConstantLight>(parameters);
}

}  // namespace metrolux::core
