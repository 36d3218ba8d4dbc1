#pragma once
#include "base/math.h"

namespace metrolux::core {

/// Right-handed orthonormal frame; local coordinates are (s, t, n), n is the local z axis.
struct Frame {
    Vec3f s, t, n;

    /// Frame around unit n with an arbitrary, continuous-almost-everywhere tangent
    /// (Duff et al. 2017, Building an Orthonormal Basis, Revisited).
    static Frame fromNormal(const Vec3f& n) {
        const float sign = std::copysign(1.0f, n.z);
        const float a = -1.0f / (sign + n.z);
        const float b = n.x * n.y * a;
        return {Vec3f(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
                Vec3f(b, sign + n.y * n.y * a, -n.y), n};
    }

    /// Frame around unit n whose s is `tangent` made orthogonal to n (Gram-Schmidt); falls back to fromNormal
    /// when the tangent is (nearly) parallel to n or zero.
    static Frame fromNormalAndTangent(const Vec3f& n, const Vec3f& tangent) {
        const Vec3f s = tangent - n * dot(n, tangent);
        const float length2 = lengthSquared(s);
        if (!(length2 > 1e-12f * lengthSquared(tangent)) || !(length2 > 0)) return fromNormal(n);
        const Vec3f unit = s * (1.0f / std::sqrt(length2));
        return {unit, cross(n, unit), n};
    }

    Vec3f toLocal(const Vec3f& v) const { return {dot(v, s), dot(v, t), dot(v, n)}; }
    Vec3f toWorld(const Vec3f& v) const { return s * v.x + t * v.y + n * v.z; }
};

inline float cosTheta(const Vec3f& v) { return v.z; }
inline float absCosTheta(const Vec3f& v) { return std::abs(v.z); }
inline float cos2Theta(const Vec3f& v) { return v.z * v.z; }
inline float sin2Theta(const Vec3f& v) { return std::max(0.0f, 1.0f - v.z * v.z); }
inline bool sameHemisphere(const Vec3f& a, const Vec3f& b) { return a.z * b.z > 0; }
/// Mirror of v about the local normal.
inline Vec3f reflectLocal(const Vec3f& v) { return {-v.x, -v.y, v.z}; }

}  // namespace metrolux::core
