#pragma once
#include "base/error.h"
#include "base/transform.h"

#include <Imath/ImathVec.h>

#include <numbers>

namespace metrolux::core {

inline constexpr double kPiD = std::numbers::pi;

inline Vec3d toDouble(const Vec3f& v) { return {v.x, v.y, v.z}; }
inline Vec3f toFloat(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Affine map with double-precision arguments: hits of analytic shapes are computed through it, so that their
/// only rounding is that of the final position.
struct Affine {
    Vec3d x, y, z, offset;  ///< images of the axes and of the origin

    Affine() : x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), offset(0) {}
    /// Throws Error for a projective map.
    explicit Affine(const Transform& t) {
        if (t.at(3, 0) != 0 || t.at(3, 1) != 0 || t.at(3, 2) != 0 || t.at(3, 3) != 1)
            throw Error("to_world of a shape must be affine, but its last row is ({}, {}, {}, {})",
                        t.at(3, 0), t.at(3, 1), t.at(3, 2), t.at(3, 3));
        const auto column = [&](int j) { return Vec3d(t.at(0, j), t.at(1, j), t.at(2, j)); };
        x = column(0), y = column(1), z = column(2), offset = column(3);
    }

    Vec3d point(const Vec3d& p) const { return offset + vector(p); }
    Vec3d vector(const Vec3d& v) const { return x * v.x + y * v.y + z * v.z; }
};

/// Bounds of `center` +- `extent`, widened by the rounding to float.
inline void boundsAround(const Vec3d& center, const Vec3d& extent, Vec3f& lower, Vec3f& upper) {
    for (int i = 0; i < 3; ++i) {
        const double slack = 1e-6 * (std::abs(center[i]) + extent[i]);
        lower[i] = static_cast<float>(center[i] - extent[i] - slack);
        upper[i] = static_cast<float>(center[i] + extent[i] + slack);
    }
}

}  // namespace metrolux::core
