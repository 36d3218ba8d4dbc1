// Rays that leave a surface must not hit it again at once, and must not skip what lies behind it.
#include "base/rng.h"
#include "base/warp.h"
#include "geometry/intersector.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

constexpr int kRays = 20000;

/// Triangles for Embree, and pairs of them.
constexpr size_t kBothKinds[] = {Intersector::kPairFrom, 0};

Transform placed(const Vec3f& offset, const Vec3f& scale, const Vec3f& axis = {1, 2, 3}, double degrees = 0) {
    return Transform::translate(offset) * Transform::rotate(axis, degrees) * Transform::scale(scale);
}

/// Rays from random points of the shape into the hemisphere outside: how many hit the shape.
int outwardHits(const ShapePtr& shape, bool cosineWeighted = true) {
    int hits = 0;
    for (const size_t pairFrom : kBothKinds) {
        const Intersector scene({shape}, {}, pairFrom);
        CounterRng rng(hashKey(7));
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
    for (const size_t pairFrom : kBothKinds)
        for (const float size : {10.0f, 100.0f, 1000.0f}) {
            const ShapePtr shape = makeRectangle(placed({0, 0, 0}, Vec3f(size), {1, 2, 3}, 35), false);
            const Intersector scene({shape}, {}, pairFrom);
            CounterRng rng(hashKey(8));
            int hits = 0;
            for (int i = 0; i < kRays; ++i) {
                const Vec2f u = rng.next2D();
                const auto& mesh = static_cast<const TriangleMesh&>(*shape);
                SurfaceInteraction si;
                mesh.interaction(0, {0.5f * (1 + 1e-3f * u.x) * (1 - 1e-3f * u.y), 0.5f * (1 - 1e-3f * u.x)},
                                 si);
                const Vec3f d =
                    normalize(Frame::fromNormal(si.ng).toWorld(warp::squareToCosineHemisphere(rng.next2D())));
                SurfaceInteraction hit;
                hits += scene.intersect({offsetRayOrigin(si.p, si.ng, d), d}, hit);
            }
            EXPECT_EQ(hits, 0) << size;
        }
}

/// Rays that go inside a closed convex shape leave it through its far side.
TEST(SelfIntersection, RaysIntoAShapeReachItsFarSide) {
    for (const float distance : {0.0f, 1.0f, 100.0f, 1e4f}) {
        SCOPED_TRACE(distance);
        const ShapePtr sphere = makeSphere(Transform(), {distance, 0, 0}, 1, false);
        const Intersector scene({sphere}, {});
        CounterRng rng(hashKey(9));
        for (int i = 0; i < kRays; ++i) {
            const SurfaceInteraction si = sphere->sampleArea(rng.next2D()).si;
            const Vec3f d =
                -normalize(Frame::fromNormal(si.ng).toWorld(warp::squareToCosineHemisphere(rng.next2D())));
            if (dot(d, si.ng) > -0.3f) continue;
            SurfaceInteraction hit;
            ASSERT_TRUE(scene.intersect({offsetRayOrigin(si.p, si.ng, d), d}, hit));
            // A chord has the length 2 cos; coordinates and offset are rounded in units of the last place.
            EXPECT_NEAR((hit.p - si.p).length(), -2 * dot(d, si.ng), 1e-4f + 2e-5f * distance);
        }
    }
}

/// A quad at a thousandth of the scale behind another one is never skipped.
TEST(SelfIntersection, NoLeaksThroughANearbyQuad) {
    for (const size_t pairFrom : kBothKinds)
        for (const float scale : {1.0f, 100.0f, 1e4f, 1e6f}) {
            SCOPED_TRACE(scale);
            const Vec3f offset = Vec3f(1, -1, 1) * scale;
            const Transform rotation = Transform::translate(offset) * Transform::rotate({1, 2, 3}, 35);
            const ShapePtr near = makeRectangle(rotation * Transform::scale(Vec3f(scale)), false);
            const ShapePtr far = makeRectangle(
                rotation * Transform::translate({0, 0, 1e-3f * scale}) * Transform::scale(Vec3f(2 * scale)),
                false);
            const Intersector scene({near, far}, {}, pairFrom);
            CounterRng rng(hashKey(10));
            for (int i = 0; i < kRays; ++i) {
                const SurfaceInteraction si = near->sampleArea(rng.next2D()).si;
                const Vec3f d =
                    normalize(Frame::fromNormal(si.ng).toWorld(warp::squareToCosineHemisphere(rng.next2D())));
                if (dot(d, si.ng) < 0.01f) continue;
                SurfaceInteraction hit;
                ASSERT_TRUE(scene.intersect({offsetRayOrigin(si.p, si.ng, d), d}, hit));
                EXPECT_EQ(hit.shape, far.get());
            }
        }
}

TEST(SelfIntersection, Instances) {
    auto group = std::make_shared<ShapeGroup>();
    group->shapes = {makeSphere(Transform(), {0, 0, 0}, 1, false)};
    for (const float distance : {1.0f, 100.0f, 1e4f}) {
        SCOPED_TRACE(distance);
        const Transform map = placed({distance, -distance, distance}, Vec3f(3, 1, 2), {1, 2, 3}, 35);
        const Intersector scene({}, {{group, map}});
        CounterRng rng(hashKey(11));
        int hits = 0;
        for (int i = 0; i < kRays; ++i) {
            const Vec3f target = map.point(warp::squareToSphere(rng.next2D()));
            const Vec3f w = warp::squareToSphere(rng.next2D());
            SurfaceInteraction si, hit;
            if (!scene.intersect({target + w * 10.0f, -w}, si)) continue;
            const Vec3f d =
                normalize(Frame::fromNormal(si.ng).toWorld(warp::squareToCosineHemisphere(rng.next2D())));
            hits += scene.intersect({offsetRayOrigin(si.p, si.ng, d), d}, hit);
        }
        EXPECT_EQ(hits, 0);
    }
}

TEST(SelfIntersection, OffsetGoesToTheSideOfTheDirection) {
    const Vec3f p(1, 2, 3), n(0, 0, 1);
    EXPECT_GT(offsetRayOrigin(p, n, {0, 0.1f, 1}).z, p.z);
    EXPECT_LT(offsetRayOrigin(p, n, {0, 0.1f, -1}).z, p.z);
    EXPECT_EQ(offsetRayOrigin(p, Vec3f(0.0f), {0, 0, 1}), p);  // an endpoint without a surface
}

}  // namespace
}  // namespace metrolux::core
