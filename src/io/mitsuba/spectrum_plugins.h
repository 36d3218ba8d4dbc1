#pragma once
#include "io/mitsuba/properties.h"

namespace metrolux::core::mitsuba {

/// The value of a <spectrum type="..."> element: uniform, regular, irregular, blackbody, d65, rgb or srgb.
/// Throws Error for other types and wrong parameters.
decltype(Property::value) spectrumFromPlugin(const Element& element);

}  // namespace metrolux::core::mitsuba
