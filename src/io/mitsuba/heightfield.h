#pragma once
#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {

/// 0.6: an image, or a nested texture of `width` x `height` samples, as heights over [-1, 1]^2 of the xy
/// plane: a mesh of two triangles between each four neighbors. The first row lies at y = -1. Throws Error.
ShapePtr makeHeightfield(const Element& element, LoadContext& context);

}  // namespace metrolux::core::mitsuba
