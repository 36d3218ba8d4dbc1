#pragma once
/// Scenes far from the origin. Points are in single precision, and rays leave surfaces by a distance in
/// proportion to the coordinates (offsetRayOrigin): a room at 1e5 times its size renders wrong. Such a scene
/// is built around an origin of its own, which SceneParts::origin keeps; others stay where they are, bit for
/// bit. What decides is where the shapes are, in the file's coordinates: neither the camera nor options.

#include "base/transform.h"
#include "geometry/shape.h"
#include "io/mitsuba/properties.h"

#include <vector>

namespace metrolux::core::mitsuba {

struct Box {
    Vec3d lower, upper;
};
Box boxOf(const Shape& shape);
/// Of a box under an affine map.
Box boxUnder(const Transform& map, const Box& box);
/// The shapes and the instances.
std::vector<Box> boxesOf(const std::vector<ShapePtr>& shapes, const std::vector<Instance>& instances);

/// Origin for things in these boxes: zero, unless most of them are much further away than they are large.
Vec3d originFor(const std::vector<Box>& boxes);
/// The same for things that were built around `origin`, which stays if it serves.
Vec3d originFor(std::vector<Box> boxes, const Vec3d& origin);
/// What "to_world" of the shapes in a <scene> says alone, without reading meshes: zero unless very far.
Vec3d guessedOrigin(const Element& scene);

/// `map`, then a translation, in double precision.
Transform movedBy(const Vec3d& offset, const Transform& map);

/// Throws Error for coordinates that are not finite or beyond 1.8e18, which is Embree's limit.
void requirePlaceable(const Element& element, const Vec3d& lower, const Vec3d& upper);

/// All properties of an element and of those in it count as unread, to build it once more.
void forgetReads(const Element& element);

}  // namespace metrolux::core::mitsuba
