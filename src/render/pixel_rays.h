#pragma once
#include "scattering/null_bsdf.h"
#include "scene/scene.h"

namespace metrolux::core {

/// Camera rays of a pixel that say what is seen there, without light: one in each cell of a square of so many
/// an axis.
inline constexpr int kStrataPerAxis = 4, kRaysOfPixel = kStrataPerAxis * kStrataPerAxis;
/// Raster position of the i-th.
inline Vec2f rasterOfRay(int x, int y, int i, const Vec2f& jitter) {
    const int column = i % kStrataPerAxis, row = i / kStrataPerAxis;
    return {static_cast<float>(x) + (static_cast<float>(column) + jitter.x) / kStrataPerAxis,
            static_cast<float>(y) + (static_cast<float>(row) + jitter.y) / kStrataPerAxis};
}

/// The surface that a ray shows: in scenes with media, boundaries that are nothing else are passed.
inline bool meetVisibleSurface(const Scene& scene, Ray ray, SurfaceInteraction& si) {
    constexpr int kMostBoundaries = 1000;
    for (int i = 0; i < kMostBoundaries && scene.intersect(ray, si); ++i) {
        if (!scene.hasMedia() || !si.shape->bsdf || !isNullBsdf(*si.shape->bsdf)) return true;
        ray.origin = offsetRayOrigin(si.p, si.ng, ray.direction);
    }
    return false;
}

}  // namespace metrolux::core
