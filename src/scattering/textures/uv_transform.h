#pragma once
#include "base/math.h"

namespace metrolux::core {

/// Affine map of texture coordinates (the `to_uv` of a texture): the upper 2x3 of a homogeneous matrix.
struct UvTransform {
    float m[2][3] = {{1, 0, 0}, {0, 1, 0}};

    Vec2f operator()(const Vec2f& uv) const {
        return {m[0][0] * uv.x + m[0][1] * uv.y + m[0][2], m[1][0] * uv.x + m[1][1] * uv.y + m[1][2]};
    }
    /// Gradient with respect to uv of a function whose gradient at the mapped point is `g` (transposed
    /// matrix).
    Vec2f pullBack(const Vec2f& g) const {
        return {m[0][0] * g.x + m[1][0] * g.y, m[0][1] * g.x + m[1][1] * g.y};
    }
};

}  // namespace metrolux::core
