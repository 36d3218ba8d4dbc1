#pragma once
#include "geometry/shape.h"

namespace metrolux::core {

/// Splits the vertices of a mesh without normals, so that only faces whose normals differ by less than
/// `degrees` share one; vertices that agree in all they have are one before that. Mitsuba 0.6's rule for
/// maxSmoothAngle: around a vertex, each face in their order joins the first group whose first face is near
/// enough. To be called before computeVertexNormals(), with valid indices. Throws Error when thousands of
/// faces meet in a vertex.
void splitAtSharpEdges(TriangleMesh& mesh, float degrees);

}  // namespace metrolux::core
