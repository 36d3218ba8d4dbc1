#pragma once
#include "base/rng.h"
#include "base/warp.h"
#include "geometry/intersector.h"

#include <gtest/gtest.h>

namespace metrolux::core {

inline void expectNear(const Vec3f& a, const Vec3f& b, float tolerance, const char* what) {
    EXPECT_LE((a - b).length(), tolerance) << what << ": (" << a.x << ", " << a.y << ", " << a.z << ") and ("
                                           << b.x << ", " << b.y << ", " << b.z << ")";
}

/// Rotation, translation and uniform scale.
inline Transform similarity() {
    return Transform::translate({1, -2, 3}) * Transform::rotate({1, 2, 3}, 50) * Transform::scale(Vec3f(2));
}

/// What must hold at every surface point.
inline void checkFrame(const SurfaceInteraction& si) {
    EXPECT_NEAR(si.ng.length(), 1, 1e-5);
    EXPECT_NEAR(si.ns.length(), 1, 1e-5);
    EXPECT_NEAR(si.s.length(), 1, 1e-5);
    EXPECT_NEAR(dot(si.s, si.ns), 0, 1e-5);
    EXPECT_GT(dot(si.ng, si.ns), 0);
}

}  // namespace metrolux::core
