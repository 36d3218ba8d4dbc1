#pragma once
#include "geometry/shape.h"
#include "io/pbrt/parameters.h"

namespace metrolux::core::pbrt {

/// Shape "curve", as a mesh of a tube in its own space (io/curve_mesh.h). Ribbons and flat curves, which turn
/// to the viewer, are as round, with a warning.
std::shared_ptr<TriangleMesh> curveMesh(const Parameters& parameters, Reading& reading);

}  // namespace metrolux::core::pbrt
