#pragma once
#include "endpoint/endpoint.h"

#include <memory>
#include <vector>

namespace metrolux {

class Shape;

struct SceneBounds {
    Vec3f center{0.0f};
    float radius = 1;  ///< of a sphere around `center` that holds all surfaces and the camera
};

class Light : public Endpoint {
  public:
    /// Emitted power (flux, luminance of its channels): for light selection.
    virtual float power() const = 0;

    /// Radiance that leaves the surface point `si` of this area light in direction w (unit, world). Zero on
    /// the back.
    virtual Rgb radiance(const SurfaceInteraction& si, const Vec3f& w) const {
        (void)si, (void)w;
        return Rgb(0.0f);
    }
    /// Radiance that an environment sends to a ray that leaves the scene in direction `w`.
    virtual Rgb environmentRadiance(const Vec3f& w) const {
        (void)w;
        return Rgb(0.0f);
    }
    /// Densities for a subpath at x whose next vertex is the point `si` of this area light.
    virtual EndpointDensities densities(const Vec3f& x, const SurfaceInteraction& si) const {
        (void)x, (void)si;
        return {};
    }
    /// Densities for a subpath that leaves x into the environment in direction `w`.
    virtual EndpointDensities environmentDensities(const Vec3f& x, const Vec3f& w) const {
        (void)x, (void)w;
        return {};
    }
    virtual bool isEnvironment() const { return false; }
    /// Whether connect() can ever succeed: not for a beam without width, which only light subpaths carry.
    virtual bool isConnectable() const { return true; }
    /// The shape that an area light covers; null for other lights.
    virtual const Shape* shape() const { return nullptr; }
    /// Called once when the scene's bounds are known (infinite lights need them).
    virtual void setSceneBounds(const SceneBounds& bounds) { (void)bounds; }
};
using LightPtr = std::shared_ptr<Light>;

}  // namespace metrolux
