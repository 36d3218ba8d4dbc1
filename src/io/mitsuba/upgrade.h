#pragma once
/// Scenes of Mitsuba 0.x: names and conventions to those of 3.x.

#include "io/mitsuba/properties.h"

#include <string>
#include <vector>

namespace metrolux::core::mitsuba {

/// toWorld to to_world, intIOR to int_ior (Mitsuba 3's rule: an underscore between a lower and an upper case
/// letter).
std::string snakeCase(const std::string& name);

/// Rewrites an element of a 0.x scene. What has no effect here or no equivalent is dropped with a warning.
void upgradeElement(Element& element, std::vector<std::string>& warnings);

}  // namespace metrolux::core::mitsuba
