#pragma once
/// Lights and cameras: the first or last vertex of a path (Mitsuba 3's Endpoint).
///
/// Both can start a subpath (sampleRay), be connected to a surface point (connect), and say with which
/// densities they would have made a given first edge. Densities are area or solid-angle densities as named.
///
/// Infinitely far endpoints (environment, directional light, orthographic camera) have no position: their ray
/// starts on a disk (or film plane) perpendicular to its direction that covers the scene, pdfPosition is the
/// density per area on that plane, and no inverse-square law applies.

#include "base/math.h"
#include "geometry/interaction.h"

#include <optional>

namespace metrolux::core {

/// A ray that leaves an endpoint.
struct EndpointRay {
    Vec3f origin{0.0f};  ///< cameras: on the near clipping plane (see Camera::projectionCenter)
    Vec3f direction{0.0f};
    Vec3f ng{
        0.0f};  ///< geometric normal at a surface endpoint (for offsetting the origin); zero if there is none
    Rgb weight{0.0f};       ///< emitted value * |cosine| / (pdfPosition * pdfDirection)
    float pdfPosition = 1;  ///< per area; 1 for a delta position
    float pdfDirection =
        1;             ///< per solid angle; 1 for a delta direction. Cameras: over the whole rendered film
    float cosine = 1;  ///< |cos| between ng and direction; 1 where there is no surface
    SurfaceInteraction surface;  ///< area lights: the point that emits, as densities() takes it
};

/// A connection between a surface point x and an endpoint.
struct EndpointConnection {
    /// Where a visibility test ends: on the endpoint, or on the near clipping plane before it; for infinite
    /// endpoints a point beyond the scene along wi.
    Vec3f point{0.0f};
    Vec3f wi{0.0f};      ///< unit direction from x toward the endpoint
    float distance = 0;  ///< between x and the endpoint's own point (not the near clipping plane)
    Vec3f ng{0.0f};      ///< geometric normal at `point`, zero if there is none
    /// Lights: emitted radiance toward x divided by pdf (intensity/distance^2 for point-like lights,
    /// irradiance for directional ones): the direct light at x is  value * S  (S contains the receiving
    /// cosine). Cameras: a light subpath that arrives at x with throughput alpha contributes
    ///     alpha * S / |wLight.Ng| * |wEye.Ng| * value   per unit of film area in pixels
    /// at filmPosition (value = d(pixel area)/d(solid angle) / distance^2 for a pinhole).
    Rgb value{0.0f};
    /// Density with which connect() picked this point: per solid angle at x; 1 for delta endpoints.
    float pdf = 1;
    /// Densities with which sampleRay() makes the ray from `point` to x.
    float pdfPosition = 1, pdfDirection = 1;
    float cosine = 1;          ///< |cos| at the endpoint between ng and -wi; 1 where there is no surface
    Vec2f filmPosition{0.0f};  ///< cameras: raster position in pixels of the full image
};

/// Densities of an endpoint that a subpath has hit (area lights and environments).
struct EndpointDensities {
    float connect = 0;      ///< density with which connect(x) picks the hit point, per solid angle at x
    float pdfPosition = 0;  ///< of sampleRay, as in EndpointRay
    float pdfDirection = 0;
    float cosine = 1;  ///< as in EndpointRay
};

class Endpoint {
  public:
    virtual ~Endpoint() = default;
    /// uPosition: point on the light or the lens; uDirection: direction, and for cameras the raster position
    /// in pixels of the full image.
    virtual std::optional<EndpointRay> sampleRay(const Vec2f& uPosition, const Vec2f& uDirection) const = 0;
    /// Connects to the surface point x. Does not test visibility. Nothing when no light can pass.
    virtual std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f& u) const = 0;

    virtual bool isInfinite() const { return false; }  ///< no inverse-square law, see above
    virtual bool isDelta() const = 0;  ///< cannot be hit by a subpath (delta position or delta direction)
};

}  // namespace metrolux::core
