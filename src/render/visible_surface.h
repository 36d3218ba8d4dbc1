#pragma once
#include "scattering/null_bsdf.h"
#include "scene/scene.h"

namespace metrolux::core {

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
