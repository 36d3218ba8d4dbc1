#include "geometry/intersector.h"

namespace metrolux {

namespace {

// Hits are rounded to float once (triangle_mesh.cpp, sphere.cpp ...): half a unit in the last place of each
// coordinate. What remains is the intersector's own error, of a few units of the coordinates of the triangle.
// 64 units cover both with a wide margin and are 4e-6 of the distance to the origin;
// tests/unit/geometry/self_intersection_test.cpp measures it. Coordinates below one count as one: triangles
// are rarely as small as their distance to the origin.
constexpr float kRelativeOffset = 0x1p-18f;

}  // namespace

Vec3f offsetRayOrigin(const Vec3f& p, const Vec3f& ng, const Vec3f& direction) {
    const float largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), 1.0f});
    const float distance = kRelativeOffset * largest;
    return p + ng * (dot(ng, direction) < 0 ? -distance : distance);
}

}  // namespace metrolux
