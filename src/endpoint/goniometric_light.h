#pragma once
#include "base/transform.h"
#include "endpoint/light.h"

#include <vector>

namespace metrolux::core {

/// Intensities over directions, as a goniometer of type C measures them: from the axis (vertical angles) in
/// half planes around it (horizontal angles). Linear between the angles; zero at vertical angles beyond them.
struct PhotometricWeb {
    std::vector<float> vertical;    ///< degrees from the axis, ascending in [0, 180]
    std::vector<float> horizontal;  ///< degrees around it, ascending; 0 alone: the same in all half planes
    std::vector<float> values;      ///< of the first half plane, then of the next; not negative

    /// At a horizontal angle in [0, 360). Webs of a quarter or of a half turn are mirrored.
    float at(float verticalDegrees, float horizontalDegrees) const;
};

struct GoniometricLightParameters {
    Transform toWorld;  ///< the axis is +z, the half plane of angle 0 contains +x, that of 90 degrees +y
    Rgb scale{1.0f};    ///< of the web's values: flux per steradian
    PhotometricWeb web;
};
/// A point light. Throws Error for parameters out of range.
LightPtr makeGoniometricLight(GoniometricLightParameters parameters);

}  // namespace metrolux::core
