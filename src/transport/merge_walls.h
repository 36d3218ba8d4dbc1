#pragma once
/// Whether a wall stands between two points that merging would take for one
/// (docs/explain/algorithm.md section 1, "Merging does not reach through walls").

#include "scene/scene.h"
#include "transport/vertex.h"

namespace metrolux::core {

/// True if every short way from the photon to the eye vertex is blocked by something that light does not
/// pass: straight along the surface, over it at the height of the merging radius, and around it half a radius
/// to both sides. What is smaller than the radius, a surface that bends or a blade of grass, is no wall.
bool isWallBetween(const Scene& scene, const Vertex& light, const Vertex& eye, float radius);

}  // namespace metrolux::core
