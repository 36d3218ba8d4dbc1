#pragma once
#include "io/mesh_io.h"
#include "io/mitsuba/properties.h"

namespace metrolux::core {

/// A mesh from a program's arrays, checked like those of a file. Throws Error.
std::shared_ptr<TriangleMesh> meshOfArrays(const mitsuba::MeshArrays& arrays, const MeshOptions& options);

}  // namespace metrolux::core
