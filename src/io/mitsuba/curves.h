#pragma once
#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {

/// 3.x: `bsplinecurve` and `linearcurve`, text files of control points, as meshes of tubes (io/curve_mesh.h).
/// Throws Error.
ShapePtr makeBSplineCurve(const Element& element, LoadContext& context);
ShapePtr makeLinearCurve(const Element& element, LoadContext& context);
/// 0.6: `hair`, a file of points and one radius.
ShapePtr makeHair(const Element& element, LoadContext& context);

}  // namespace metrolux::core::mitsuba
