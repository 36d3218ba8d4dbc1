#pragma once
#include "endpoint/camera.h"
#include "io/mitsuba/properties.h"

namespace metrolux::core::mitsuba {

/// The angle that a perspective camera or a projector takes in.
struct FieldOfView {
    float degrees = 0;
    FovAxis axis = FovAxis::X;
    /// Half the width on the plane at distance 1 of an image with the aspect ratio width / height.
    float tanHalfWidth(float aspect) const { return perspectiveHalfWidth(degrees, axis, aspect); }
};

/// From `fov` and `fov_axis`, or `focal_length` of a 35 mm film ("50mm" if neither is given). Throws Error.
FieldOfView readFieldOfView(const Element& element);

/// Whether the map is a rotation, translation, reflection and uniform scaling.
bool isSimilarity(const Transform& transform);

}  // namespace metrolux::core::mitsuba
