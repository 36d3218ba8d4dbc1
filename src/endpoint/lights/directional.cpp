#include "endpoint/lights.h"
#include "endpoint/lights/infinite.h"

namespace metrolux::core {

namespace {

class DirectionalLight final : public InfiniteLight {
  public:
    explicit DirectionalLight(const DirectionalLightParameters& p)
        : direction_(normalize(p.direction)), irradiance_(p.irradiance) {
        requireEmission(irradiance_, "directional");
        if (!isFinite(p.direction) || !(direction_.length() > 0.5f))
            throw Error("directional light: the direction has no length");
    }

    LightPtr copy() const override { return std::make_shared<DirectionalLight>(*this); }
    float power() const override { return luminance(irradiance_) * diskArea(); }
    bool isDelta() const override { return true; }

    std::optional<EndpointRay> sampleRay(const Vec2f& uPosition, const Vec2f&) const override {
        EndpointRay ray;
        ray.origin = diskPoint(direction_, uPosition);
        ray.direction = direction_;
        ray.pdfPosition = diskPdf();
        ray.weight = irradiance_ * diskArea();
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f&) const override {
        if (isBlack(irradiance_)) return std::nullopt;
        EndpointConnection c = connectionAlong(x, -direction_);
        c.value = irradiance_;
        return c;
    }

  protected:
    void scaleEmission(float factor) override { irradiance_ *= factor; }

  private:
    Vec3f direction_;
    Rgb irradiance_;
};

}  // namespace

LightPtr makeDirectionalLight(const DirectionalLightParameters& parameters) {
    return std::make_shared<DirectionalLight>(parameters);
}

}  // namespace metrolux::core
