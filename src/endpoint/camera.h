#pragma once
#include "base/error.h"
#include "base/transform.h"
#include "endpoint/endpoint.h"
#include "geometry/medium_sides.h"
#include "image/film_window.h"

#include <array>
#include <memory>
#include <optional>

namespace metrolux::core {

/// A camera. Its densities are over the whole rendered window: a raster position is one of pixelCount() unit
/// squares.
class Camera : public Endpoint {
  public:
    explicit Camera(const FilmWindow& window) : window_(window) {}
    const FilmWindow& window() const { return window_; }
    bool isDelta() const override { return true; }  // no subpath hits a lens
    /// What the camera stands in; nothing where the scene is to find out from the boundaries around it.
    std::optional<MediumIndex> medium;
    /// Approximate width of a pixel's footprint at distance d (scene units): for the merging radius.
    virtual float pixelFootprint(float distance) const = 0;
    virtual Vec3f position() const = 0;
    /// What other programs need to place things in the image, as OpenEXR's standard attributes of these names
    /// define it. Row by row; points of the world are rows that are multiplied from the left.
    struct Matrices {
        /// x points to the right in the image, y up, z along the view.
        std::array<float, 16> worldToCamera;
        /// (0, 0) is the upper left, (1, 1) the lower right corner of the full image; z says nothing.
        std::array<float, 16> worldToNdc;
    };
    /// Nothing for cameras whose image is no projection onto a plane.
    virtual std::optional<Matrices> matrices() const { return std::nullopt; }
    /// The point on the lens (or pinhole) from which distances along a sampled ray count: rays may start at a
    /// near plane.
    virtual Vec3f projectionCenter(const Vec3f& origin, const Vec3f& direction) const {
        (void)direction;
        return origin;
    }

  protected:
    /// Throws Error, which names the camera, unless the window has pixels.
    static void requireFilm(const FilmWindow& window, const char* camera) {
        if (window.fullWidth <= 0 || window.fullHeight <= 0 || window.pixelCount() <= 0)
            throw Error("{} camera: the film is empty ({} x {})", camera, window.fullWidth,
                        window.fullHeight);
    }
    /// From the axes of the camera as seen in the image, each with a constant term; x, y and w are the
    /// homogeneous coordinates in which the image is projected.
    struct Row {
        Vec3f axis{0.0f};
        float constant = 0;
    };
    static std::array<float, 16> matrixOf(const Row& x, const Row& y, const Row& z, const Row& w) {
        std::array<float, 16> m;
        for (size_t i = 0; i < 4; ++i) {
            const Row* const columns[] = {&x, &y, &z, &w};
            for (size_t c = 0; c < 4; ++c)
                m[4 * i + c] = i < 3 ? columns[c]->axis[static_cast<int>(i)] : columns[c]->constant;
        }
        return m;
    }

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
