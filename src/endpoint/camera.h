#pragma once
#include "base/transform.h"
#include "endpoint/endpoint.h"
#include "image/film_window.h"

#include <memory>

namespace metrolux::core {

/// A camera. Its densities are over the whole rendered window: a raster position is one of pixelCount() unit
/// squares.
class Camera : public Endpoint {
  public:
    explicit Camera(const FilmWindow& window) : window_(window) {}
    const FilmWindow& window() const { return window_; }
    bool isDelta() const override { return true; }  // no subpath hits a lens
    /// Approximate width of a pixel's footprint at distance d (scene units): for the merging radius.
    virtual float pixelFootprint(float distance) const = 0;
    virtual Vec3f position() const = 0;
    /// The point on the lens (or pinhole) from which distances along a sampled ray count: rays may start at a
    /// near plane.
    virtual Vec3f projectionCenter(const Vec3f& origin, const Vec3f& direction) const {
        (void)direction;
        return origin;
    }

  protected:
    FilmWindow window_;
};
using CameraPtr = std::shared_ptr<Camera>;

enum class FovAxis { X, Y, Diagonal, Smaller, Larger };

/// Half the width, on the plane at distance 1, of a perspective image with the aspect ratio width / height
/// that takes in `fov` degrees along the axis. Throws Error unless fov is in (0, 180).
float perspectiveHalfWidth(float fov, FovAxis axis, float aspect);

struct PerspectiveParameters {
    Transform toWorld;     ///< camera space looks along +z, +y up, +x to the left (Mitsuba)
    float fov = 39.3077f;  ///< degrees along the axis
    FovAxis axis = FovAxis::X;
    float nearClip = 1e-2f;  ///< surfaces nearer than this along the axis are not seen
    float principalOffsetX = 0, principalOffsetY = 0;  ///< in fractions of the image
    float apertureRadius = 0;                          ///< 0: pinhole
    float focusDistance = 1;                           ///< along the axis
};
/// Pinhole or thin lens. Throws Error for parameters out of range. The lengths of the columns of `toWorld`
/// are ignored.
CameraPtr makePerspectiveCamera(const PerspectiveParameters& parameters, const FilmWindow& window);

struct OrthographicParameters {
    Transform toWorld;       ///< the film covers [-1,1] in camera x, scaled by the map
    float nearClip = 1e-2f;  ///< in camera space
};
CameraPtr makeOrthographicCamera(const OrthographicParameters& parameters, const FilmWindow& window);

}  // namespace metrolux::core
