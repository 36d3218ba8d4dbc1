#pragma once
#include "geometry/shape.h"
#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {

/// Mitsuba 3's `sdfgrid`, as a mesh (io/distance_field.h).
ShapePtr makeDistanceShape(const Element& element, LoadContext& context);

}  // namespace metrolux::core::mitsuba
