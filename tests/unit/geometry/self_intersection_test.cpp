// Rays that leave a surface must not hit it again at once, and must not skip what lies behind it.
#include "base/rng.h"
#include "base/warp.h"
#include "geometry/intersector.h"

#include <gtest/gtest.h>

namespace metrolux {
namespace {

constexpr int kRays = 20000;

Transform placed(const Vec3f& offset, const Vec3f& scale, const Vec3f& axis = {1, 2, 3}, double degrees = 0) {
    return Transform::translate(offset) * Transform::rotate(axis, degrees) * Transform::scale(scale);
}

/// Rays from random points of the shape into the hemisphere outside: how many hit the shape.
int outwardHits(const ShapePtr& shape, bool cosineWeighted = true) {
    const Intersector scene({shape}, {});
    CounterRng rng(hashKey(7));
    int hits = 0;
    for (int i = 0; i < kRays; ++i) {
        const SurfaceInteraction si = shape->sampleArea(rng.next2D()).si;
        Vec3f local = cosineWeighted ? warp::squareToCosineHemisphere(rng.next2D())
                                     : warp::squareToSphere(rng.next2D());
        local.z = std::abs(local.z);
        const Vec3f d = normalize(Frame::fromNormal(si.ng).toWorld(local));
        if (!(dot(d, si.ng) > 0)) continue;
        const Ray ray{offsetRayOrigin(si.p, si.ng, d), d};
        SurfaceInteraction hit;
        const bool found = scene.intersect(ray, hit);
        EXPECT_EQ(found, scene.occluded(ray));
        hits += found;
    }
    return hits;
}

TEST(SelfIntersection, ConvexShapesAtAnyCoordinate) {
    for (const float distance : {0.0f, 1.0f, 100.0f, 1e4f, 1e5f}) {
        SCOPED_TRACE(distance);
        const Vec3f offset(distance, distance * 0.3f, -distance * 0.7f);
        EXPECT_EQ(outwardHits(makeSphere(Transform(), offset, 1, false)), 0);
        EXPECT_EQ(outwardHits(makeDisk(placed(offset, Vec3f(1), {1, 2, 3}, 35), false)), 0);
        EXPECT_EQ(outwardHits(
                      makeCylinder(placed(offset, Vec3f(1), {1, 2, 3}, 35), {0, 0, 0}, {0, 0, 1}, 1, false)),
                  0);
        EXPECT_EQ(outwardHits(makeRectangle(placed(offset, Vec3f(1), {1, 2, 3}, 35), false)), 0);
        EXPECT_EQ(outwardHits(makeCube(placed(offset, Vec3f(1), {1, 2, 3}, 35), false)), 0);
    }
}

TEST(SelfIntersection, SphereFarAwayOnTheAxis) {
    EXPECT_EQ(outwardHits(makeSphere(Transform(), {1e5f, 0, 0}, 1, false), false), 0);
}

TEST(SelfIntersection, TrianglesAtAMillion) {
    for (const double degrees : {0.0, 35.0, 71.0})
        for (const float size : {10.0f, 1000.0f, 1e5f})
            EXPECT_EQ(outwardHits(
                          makeRectangle(placed({1e6f, -1e6f, 1e6f}, Vec3f(size), {1, 2, 3}, degrees), false)),
                      0)
                << degrees << " " << size;
}

TEST(SelfIntersection, LargeTiltedTrianglesNearTheOrigin) {
    for (const float size : {10.0f, 100.0f, 1000.0f}) {
        const ShapePtr shape = makeRectangle(placed({0, 0, 0}, Vec3f(size), {1, 2, 3}, 35), false);
        const Intersector scene({shape}, {});
        CounterRng rng(hashKey(8));
        int hits = 0;
        for (int i = 0; i < kRays; ++i) {
            const Vec2f u = rng.next2D();
            const auto& mesh = static_cast<const TriangleMesh&>(*shape);
            SurfaceInteraction si;
            mesh.interaction(0, {0.5f * (1 + 1e-3f * u.x) * (1 - 1e-3f * u.y), 0.5f * (1 - 1e-3f * u.x)}, si);
            const Vec3f d =
                normalize(Frame::fromNormal(si.ng).toWorld(warp::squareToCosineHemisphere(rng.next2D())));
            SurfaceInteraction hit;
            hits += scene.intersect({offsetRayOrigin(si.p, si.ng, d), d}, hit);
        }
        EXPECT_EQ(hits, 0) << size;
    }
}

}  // namespace
}  // namespace metrolux
