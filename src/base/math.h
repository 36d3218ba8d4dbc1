#pragma once
/// Vector, color and ray types, and the few scalar helpers that every module needs.
/// Lengths are in scene units, angles in radians, radiometric values linear Rec.709 RGB.

#include <Imath/ImathColor.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace metrolux::core {

using Vec2f = Imath::V2f;
using Vec3f = Imath::V3f;
using Vec2i = Imath::V2i;
using Rgb = Imath::Color3f;

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// The largest float below 1: primary samples live in [0, kOneMinusEpsilon].
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

inline float dot(const Vec3f& a, const Vec3f& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float absDot(const Vec3f& a, const Vec3f& b) { return std::abs(dot(a, b)); }
inline Vec3f cross(const Vec3f& a, const Vec3f& b) { return a.cross(b); }
inline Vec3f normalize(const Vec3f& v) { return v.normalized(); }
inline float lengthSquared(const Vec3f& v) { return dot(v, v); }
template <class T>
constexpr T sqr(T x) {
    return x * x;
}
inline float safeSqrt(float x) { return std::sqrt(std::max(x, 0.0f)); }
inline float lerp(float t, float a, float b) { return a + t * (b - a); }
inline float radians(float degrees) { return degrees * (kPi / 180.0f); }

/// Rec.709 luminance.
inline float luminance(const Rgb& c) { return 0.212671f * c.x + 0.715160f * c.y + 0.072169f * c.z; }
inline float maxComponent(const Rgb& c) { return std::max({c.x, c.y, c.z}); }
inline float average(const Rgb& c) { return (c.x + c.y + c.z) * (1.0f / 3.0f); }
inline bool isBlack(const Rgb& c) { return c.x == 0 && c.y == 0 && c.z == 0; }
inline bool isFinite(const Rgb& c) { return std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z); }
inline bool isFinite(const Vec3f& c) {
    return std::isfinite(c.x) && std::isfinite(c.y) && std::isfinite(c.z);
}
inline Rgb lerp(float t, const Rgb& a, const Rgb& b) { return a * (1.0f - t) + b * t; }

/// A half-line; `direction` is of unit length, so that `tMax` is a distance.
struct Ray {
    Vec3f origin{0.0f};
    Vec3f direction{0.0f};
    float tMax = kInfinity;
};

}  // namespace metrolux::core
