#include "transport/merge_walls.h"

namespace metrolux::core {

namespace {

/// Heights above the surface, and the way around, in radii.
constexpr float kLow = 0.1f, kHigh = 1.0f, kAside = 0.5f;
/// Segments end before what lies at their end.
constexpr float kShortOfTheEnd = 1 - 1e-5f;
/// Transmissive surfaces that one segment may cross.
constexpr int kMostCrossed = 8;

/// Whether light gets from a to b: nothing is there but what transmits it.
bool passes(const Scene& scene, const Vec3f& a, const Vec3f& b) {
    const Vec3f d = b - a;
    const float distance = d.length();
    if (!(distance > 0)) return true;
    Ray ray{a, d * (1.0f / distance), distance * kShortOfTheEnd};
    if (scene.isFree(ray)) return true;
    SurfaceInteraction si;
    for (int crossed = 0; crossed < kMostCrossed; ++crossed) {
        if (!scene.intersect(ray, si)) return true;
        if (!si.shape->bsdf->isTransmissive()) return false;
        ray.origin = offsetRayOrigin(si.p, si.ng, ray.direction);
        ray.tMax = dot(b - ray.origin, ray.direction) * kShortOfTheEnd;
        if (!(ray.tMax > 0)) return true;
    }
    return true;
}

}  // namespace

bool isWallBetween(const Scene& scene, const Vertex& light, const Vertex& eye, float radius) {
    // What stands on the side that is lit decides: from the other side the eye sees the same light through
    // it.
    const float side = dot(light.si.ng, light.toPrevious) < 0 ? -1.0f : 1.0f;
    const Vec3f n0 = eye.si.ng * side, n1 = light.si.ng * side;
    const Vec3f p0 = offsetRayOrigin(eye.si.p, n0, n0), p1 = offsetRayOrigin(light.si.p, n1, n1);
    const Vec3f d = p1 - p0;
    // Where the surface bends away between them it rises above the segment: by a third of this at most, which
    // is the case of an edge of 60 degrees halfway.
    const float bend = std::max(0.0f, dot(d, n1 - n0)) / 3;
    const Vec3f low0 = n0 * (kLow * radius + bend), low1 = n1 * (kLow * radius + bend);
    // Nearly all merges are decided here. The second is for the end of a wedge, where a lifted end lies
    // beyond the other surface.
    if (passes(scene, p0 + low0, p1 + low1) || passes(scene, p0 + n0 * bend, p1 + n1 * bend)) return false;

    const auto leadsAround = [&](const Vec3f& by0, const Vec3f& by1) {
        const Vec3f a = p0 + by0, b = p1 + by1;
        return passes(scene, a, b) && passes(scene, p0, a) && passes(scene, p1, b);
    };
    if (leadsAround(n0 * (kHigh * radius), n1 * (kHigh * radius))) return false;
    const Vec3f across = cross(n0, d);
    const float length = across.length();
    if (!(length > 0)) return false;
    const Vec3f aside = across * (kAside * radius / length);
    return !leadsAround(low0 + aside, low1 + aside) && !leadsAround(low0 - aside, low1 - aside);
}

}  // namespace metrolux::core
