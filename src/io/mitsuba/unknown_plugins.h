#pragma once
#include "io/mitsuba/properties.h"

#include <string>
#include <vector>

namespace metrolux::core::mitsuba {

/// What to say of a plugin that there is not: that it is Mitsuba's and not supported, with what is nearest;
/// or else the nearest of the `known` names. `kind`: "BSDF", "shape" ...
std::string unknownPlugin(const Element& element, const std::string& kind,
                          const std::vector<std::string>& known);

}  // namespace metrolux::core::mitsuba
