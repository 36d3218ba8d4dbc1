#pragma once
#include "base/math.h"

#include <cstdint>
#include <span>

namespace metrolux::core {

/// Two successive triangles of a mesh that share an edge, which they pass in opposite directions, are a pair:
/// Embree can have them as one quadrilateral. Its vertices v0, v1, v3 are the first triangle, v2, v3, v1 the
/// second.

/// How many triangles have a partner when each that has none yet is paired with its successor where that is
/// possible. `indices`: three per triangle, here and below.
size_t pairedTriangles(std::span<const uint32_t> indices);

/// Writes four indices for each triangle. Those at the first triangle of a pair are the quadrilateral, those
/// at the second are out of any range, so that Embree leaves them out. A triangle without partner has its
/// last vertex twice.
void writeQuadrilaterals(std::span<const uint32_t> indices, uint32_t* quadrilaterals);

/// A point of a triangle.
struct TrianglePoint {
    uint32_t triangle = 0;
    Vec2f barycentric{0.0f};  ///< (b1, b2)
};
/// Where Embree's point uv of a quadrilateral is, which writeQuadrilaterals() wrote at the triangle
/// `quadrilateral`.
TrianglePoint pointOfQuadrilateral(std::span<const uint32_t> indices, uint32_t quadrilateral,
                                   const Vec2f& uv);

/// Embree gives points of a pair's second triangle coordinates of the parallelogram's other half. (So may
/// rounding do for a triangle without partner: pointOfQuadrilateral() looks.)
inline bool onSecondTriangle(const Vec2f& uv) { return uv.x + uv.y > 1; }

}  // namespace metrolux::core
