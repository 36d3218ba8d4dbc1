#pragma once
#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {

/// `sunsky`, and `sky` and `sun` of 0.6. Null, with a warning, when the sun of a 3.x scene has set.
LightPtr makeSunSkyLight(const Element& element, LoadContext& context);

}  // namespace metrolux::core::mitsuba
