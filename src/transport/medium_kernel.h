#pragma once
#include "scene/scene.h"
#include "transport/vertex.h"

namespace metrolux::core {

/// Part of the ball of that radius around a vertex in a medium that light can scatter in and reach the vertex
/// from, in (0, 1]. Merging that divided by the whole ball would darken what lies near a boundary, in dense
/// media all that one sees. The surfaces nearby are taken for planes: exact for one, close for a corner.
float shareInside(const Scene& scene, const Vertex& v, float radius);

}  // namespace metrolux::core
