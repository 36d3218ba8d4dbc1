#pragma once
#include <cstdint>

namespace metrolux::core {

/// Place of a medium in SceneParts::media, plus one; 0 is empty space.
using MediumIndex = uint16_t;

/// What lies on the two sides of a surface.
struct MediumSides {
    MediumIndex interior = 0;  ///< against the geometric normal
    MediumIndex exterior = 0;
};

}  // namespace metrolux::core
