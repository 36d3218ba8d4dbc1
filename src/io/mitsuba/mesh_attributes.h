#pragma once
#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {

/// Throws Error (or, when lenient, warns) for an attribute that a texture of the BSDF or emitter reads and
/// the shape does not have, naming those that it has.
void checkAttributes(const Element& element, const Shape& shape, LoadContext& context);

}  // namespace metrolux::core::mitsuba
