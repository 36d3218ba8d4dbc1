#include "transport/medium_kernel.h"

#include "transport/passage.h"

#include <array>

namespace metrolux::core {

namespace {

struct Plane {
    Vec3f normal;
    float distance;
};

/// Part of a unit ball on the side of its center from a plane at this distance from it.
float sharePastPlane(float z) { return 0.5f + z * (0.75f - 0.25f * z * z); }

/// To the faces and the corners of a cube: no plane that takes more than a hundredth of the ball misses all.
std::array<Vec3f, 14> makeDirections() {
    std::array<Vec3f, 14> result;
    for (int i = 0; i < 6; ++i) {
        result[i] = Vec3f(0.0f);
        result[i][i / 2] = i % 2 ? 1.0f : -1.0f;
    }
    for (int i = 0; i < 8; ++i)
        result[6 + i] = normalize(Vec3f(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f));
    return result;
}

}  // namespace

float shareInside(const Scene& scene, const Vertex& v, float radius) {
    static const std::array<Vec3f, 14> kDirections = makeDirections();
    constexpr float kSamePlane = 0.9f;
    std::array<Plane, 3> planes;
    size_t count = 0;
    for (const Vec3f& w : kDirections) {
        SurfaceInteraction si;
        if (!scene.intersect({v.si.p, w, radius}, si)) continue;
        const bool passes = si.shape->bsdf->hasNullLobe() && mediumBeyond(si, w, v.medium) == v.medium;
        if (passes) continue;
        const Plane plane{si.ng, std::min(absDot(si.p - v.si.p, si.ng) / radius, 1.0f)};
        size_t same = 0;
        while (same < count && absDot(planes[same].normal, plane.normal) < kSamePlane) ++same;
        if (same < count)
            planes[same].distance = std::min(planes[same].distance, plane.distance);
        else if (count < planes.size())
            planes[count++] = plane;
    }
    float share = 1;
    for (size_t i = 0; i < count; ++i) share *= sharePastPlane(planes[i].distance);
    return share;
}

}  // namespace metrolux::core
