#pragma once
/// Maps from the unit square to the distributions that rendering needs, with their densities.
/// Each warp has `map` and `pdf` (solid angle or area measure, said at each).

#include "base/math.h"

namespace metrolux::core::warp {

/// Sine and cosine for |x| <= pi/4, to about a unit in the last place (the polynomials of Moshier's Cephes).
inline void sinCosNearZero(float x, float& sine, float& cosine) {
    const float x2 = x * x;
    sine = x + x * x2 * (-1.6666654611e-1f + x2 * (8.3321608736e-3f + x2 * -1.9515295891e-4f));
    cosine = 1.0f - 0.5f * x2 +
             x2 * x2 * (4.166664568298827e-2f + x2 * (-1.388731625493765e-3f + x2 * 2.443315711809948e-5f));
}

/// Concentric map of the unit square onto the unit disk (Shirley & Chiu 1997); density 1/pi per area. Without
/// branches: which of the coordinates is larger is anybody's guess.
inline Vec2f squareToDisk(const Vec2f& u) {
    const float x = 2.0f * u.x - 1.0f, y = 2.0f * u.y - 1.0f;
    const bool wide = std::abs(x) > std::abs(y);
    const float r = wide ? x : y, other = wide ? y : x;
    float sine, cosine;  // of the angle to the axis of the larger coordinate
    sinCosNearZero((kPi / 4.0f) * (other / (r != 0 ? r : 1.0f)), sine, cosine);
    const float along = r * cosine, across = r * sine;
    return wide ? Vec2f(along, across) : Vec2f(across, along);
}

/// Cosine-weighted hemisphere around +z; density |cos|/pi per solid angle.
inline Vec3f squareToCosineHemisphere(const Vec2f& u) {
    const Vec2f d = squareToDisk(u);
    return {d.x, d.y, std::max(1e-6f, safeSqrt(1.0f - d.x * d.x - d.y * d.y))};
}
inline float cosineHemispherePdf(const Vec3f& v) { return v.z > 0 ? v.z * kInvPi : 0.0f; }

/// Uniform on the unit sphere; density 1/(4 pi) per solid angle.
inline Vec3f squareToSphere(const Vec2f& u) {
    const float z = 1.0f - 2.0f * u.y;
    const float r = safeSqrt(1.0f - z * z);
    const float phi = 2.0f * kPi * u.x;
    return {r * std::cos(phi), r * std::sin(phi), z};
}
inline constexpr float kUniformSpherePdf = 0.25f * kInvPi;

/// Uniform in the cone around +z whose half angle has the cosine cosMax; density 1/(2 pi (1-cosMax)).
/// `oneMinusCosMax` is taken instead of the cosine because it keeps precision for narrow cones.
inline Vec3f squareToCone(const Vec2f& u, float oneMinusCosMax) {
    const float d = u.y * oneMinusCosMax;
    const float r = safeSqrt(d * (2.0f - d));
    const float phi = 2.0f * kPi * u.x;
    return {r * std::cos(phi), r * std::sin(phi), 1.0f - d};
}
inline float uniformConePdf(float oneMinusCosMax) { return 1.0f / (2.0f * kPi * oneMinusCosMax); }

/// Uniform barycentric coordinates (b1, b2) of a triangle.
inline Vec2f squareToTriangle(const Vec2f& u) {
    const float s = std::sqrt(1.0f - u.x);
    return {1.0f - s, u.y * s};
}

}  // namespace metrolux::core::warp
