#pragma once
#include "io/curve_mesh.h"

namespace metrolux::core {

/// Hairs of Mitsuba 0.6, all of one radius: a text of "x y z" a line with an empty line between two hairs, or
/// "BINARY_HAIR", the number of points as 32 bit integer, and the coordinates as 32 bit floats, of which an
/// infinite one begins a hair (little-endian). Throws Error.
std::vector<std::vector<CurvePoint>> readHairs(const std::filesystem::path& path, const MeshOptions& options,
                                               double radius);

}  // namespace metrolux::core
