#pragma once
#include "base/math.h"

namespace metrolux::core {

/// All unit directions within an angle of an axis. Angles are kept as cosines. Default: all directions.
struct DirectionCone {
    Vec3f axis{0, 0, 1};  ///< unit
    float cosine = -1;    ///< of the angle between the axis and the rim
};

/// cos(a - b), or 1 where b > a; for angles in [0, pi].
inline float cosOfDifference(float cosA, float sinA, float cosB, float sinB) {
    const float difference = cosA * cosB + sinA * sinB;
    return cosA > cosB ? 1.0f : difference;
}

/// cos(a + b), or -1 where a + b > pi; for angles in [0, pi].
inline float cosOfSum(float cosA, float cosB) {
    if (cosA <= -cosB) return -1;
    return cosA * cosB - safeSqrt(1 - cosA * cosA) * safeSqrt(1 - cosB * cosB);
}

/// Cosine of the cone around unit `axis` that just holds `cone`.
inline float cosineAround(const Vec3f& axis, const DirectionCone& cone) {
    return cosOfSum(std::clamp(dot(axis, cone.axis), -1.0f, 1.0f), cone.cosine);
}

}  // namespace metrolux::core
