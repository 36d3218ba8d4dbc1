#pragma once
/// Cameras without a film plane: a raster position is a direction.

#include "endpoint/camera.h"

namespace metrolux::core {

struct WideCameraParameters {
    Transform toWorld;   ///< camera space looks along +z, +y up, +x to the left; without scale
    float nearClip = 0;  ///< surfaces nearer than this to the center are not seen
};

/// All directions as latitude and longitude: the middle of the image is +z, its upper edge +y. The image is
/// an environment map whose `to_world` is the camera's. Mitsuba 0.6's "spherical". Throws Error for
/// parameters out of range.
CameraPtr makePanoramaCamera(const WideCameraParameters& parameters, const FilmWindow& window);

/// Equidistant projection: the distance from the middle of the image is in proportion to the angle from +z.
/// The circle that touches the nearer edges of the image takes in `aperture` degrees in (0, 360]; what lies
/// outside of it is black. Throws Error for parameters out of range.
CameraPtr makeFisheyeCamera(const WideCameraParameters& parameters, float aperture, const FilmWindow& window);

}  // namespace metrolux::core
