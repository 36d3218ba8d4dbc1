#pragma once
/// Spheres and cylinders whose placement is no similarity: Mitsuba warns, and keeps them round.

#include "geometry/shape.h"
#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {

ShapePtr makeSphereShape(const Element& element, LoadContext& context);
ShapePtr makeCylinderShape(const Element& element, LoadContext& context);

}  // namespace metrolux::core::mitsuba
