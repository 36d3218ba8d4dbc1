#include "endpoint/lights.h"
#include "endpoint/lights/emission.h"

namespace metrolux::core {

namespace {

class CollimatedLight final : public Light {
  public:
    explicit CollimatedLight(const CollimatedLightParameters& p)
        : position_(p.toWorld.point(Vec3f(0.0f))), direction_(localAxes(p.toWorld).n), power_(p.power) {
        requireEmission(power_, "collimated");
    }

    float power() const override { return luminance(power_); }
    bool isDelta() const override { return true; }
    bool isConnectable() const override { return false; }

    std::optional<EndpointRay> sampleRay(const Vec2f&, const Vec2f&) const override {
        EndpointRay ray;
        ray.origin = position_;
        ray.direction = direction_;
        ray.weight = power_;
        return ray;
    }
    std::optional<EndpointConnection> connect(const Vec3f&, const Vec2f&) const override {
        return std::nullopt;
    }

  protected:
    void scaleEmission(float factor) override { power_ *= factor; }

  private:
    Vec3f position_, direction_;
    Rgb power_;
};

}  // namespace

LightPtr makeCollimatedLight(const CollimatedLightParameters& parameters) {
    return std::make_shared<CollimatedLight>(parameters);
}

}  // namespace metrolux::core
