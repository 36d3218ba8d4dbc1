#include "geometry/triangle_pairs.h"

#include <algorithm>
#include <optional>

namespace metrolux::core {

namespace {

/// The corners of two triangles that are not on their common edge.
struct Corners {
    int first = 0, second = 0;
};

/// Those of a triangle and its successor, nothing if they are no pair.
std::optional<Corners> pairAt(std::span<const uint32_t> indices, size_t triangle) {
    if (3 * triangle + 6 > indices.size()) return {};
    const uint32_t* v = &indices[3 * triangle];
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            if (v[(i + 1) % 3] == v[3 + (k + 2) % 3] && v[(i + 2) % 3] == v[3 + (k + 1) % 3])
                return Corners{i, k};
    return {};
}

}  // namespace

size_t pairedTriangles(std::span<const uint32_t> indices) {
    size_t paired = 0;
    for (size_t i = 0; i < indices.size() / 3; ++i)
        if (pairAt(indices, i)) paired += 2, ++i;
    return paired;
}

void writeQuadrilaterals(std::span<const uint32_t> indices, uint32_t* out) {
    for (size_t i = 0; i < indices.size() / 3; ++i, out += 4) {
        const uint32_t* v = &indices[3 * i];
        if (const auto pair = pairAt(indices, i)) {
            out[0] = v[pair->first];
            out[1] = v[(pair->first + 1) % 3];
            out[2] = v[3 + pair->second];
            out[3] = v[(pair->first + 2) % 3];
            out += 4;
            std::fill_n(out, 4, ~0u);
            ++i;
        } else {
            out[0] = v[0], out[1] = v[1], out[2] = out[3] = v[2];
        }
    }
}

TrianglePoint pointOfQuadrilateral(std::span<const uint32_t> indices, uint32_t quadrilateral,
                                   const Vec2f& uv) {
    const auto pair = pairAt(indices, quadrilateral);
    if (!pair) return {quadrilateral, uv};
    const bool second = onSecondTriangle(uv);
    // From the triangle's corner that the other does not have.
    const int corner = second ? pair->second : pair->first;
    const Vec2f along = second ? Vec2f(1) - uv : uv;
    float b[3];
    b[corner] = 1 - along.x - along.y;
    b[(corner + 1) % 3] = along.x;
    b[(corner + 2) % 3] = along.y;
    return {quadrilateral + (second ? 1 : 0), {b[1], b[2]}};
}

}  // namespace metrolux::core
