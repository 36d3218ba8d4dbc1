#pragma once
#include "base/direction_cone.h"
#include "endpoint/endpoint.h"
#include "geometry/medium_sides.h"

#include <memory>
#include <vector>

namespace metrolux::core {

class Shape;

struct SceneBounds {
    Vec3f center{0.0f};
    float radius = 1;  ///< of a sphere around `center` that holds all surfaces and the camera
    bool operator==(const SceneBounds&) const = default;
};

/// Where a light is and where it shines, for light selection (after Conty Estevez & Kulla 2018, 4.1).
/// `lower`, `upper`, `normals` and `cosEmission` are conservative: no light leaves from elsewhere nor in
/// other directions, but for rounding.
struct LightBounds {
    Vec3f lower{0.0f}, upper{0.0f};  ///< box of all points that emit
    DirectionCone normals;           ///< holds the axis of emission at each of them
    /// Cosine of the largest angle, at most 90 degrees, between such an axis and the light that leaves: 0 for
    /// surfaces, whose axes are their normals; 1 for beams, whose cone `normals` is the beam.
    float cosEmission = 0;
    /// Flux per steradian (luminance) where it shines, seen from afar: a scale, not a bound.
    float intensity = 0;
};

class Light : public Endpoint {
  public:
    /// Emitted power (flux, luminance of its channels): for light selection.
    virtual float power() const = 0;

    /// The light emits 2^exponent times what the other functions say. 0, unless the scene is too bright or
    /// too dark for single precision and for the sums of the film: see Scene::emissionExponent().
    int emissionExponent() const { return emissionExponent_; }
    void setEmissionExponent(int exponent);

    /// What the light stands in; nothing where the scene is to find out. An area light on a surface that
    /// bounds a medium is in what lies on the side that it shines to.
    std::optional<MediumIndex> medium;

    /// Nothing for lights that are nowhere in particular: infinite ones, and those that are not connectable.
    virtual std::optional<LightBounds> bounds() const { return std::nullopt; }

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
    /// A light like this one for a scene of other bounds; null where bounds make no difference.
    virtual std::shared_ptr<Light> copy() const { return nullptr; }

  protected:
    /// `factor`: a power of two.
    virtual void scaleEmission(float factor) = 0;

  private:
    int emissionExponent_ = 0;
};
using LightPtr = std::shared_ptr<Light>;

}  // namespace metrolux::core
