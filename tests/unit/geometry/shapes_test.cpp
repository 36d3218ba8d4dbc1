// Rays against closed forms, and derivatives against differences, for every shape.
#include "base/error.h"
#include "support.h"

#include <functional>

namespace metrolux::core {
namespace {

SurfaceInteraction hit(const ShapePtr& shape, const Vec3f& origin, const Vec3f& direction) {
    SurfaceInteraction si;
    const Intersector scene({shape}, {});
    EXPECT_TRUE(scene.intersect({origin, normalize(direction)}, si));
    EXPECT_EQ(si.shape, shape.get());
    checkFrame(si);
    return si;
}

bool misses(const ShapePtr& shape, const Vec3f& origin, const Vec3f& direction, float tMax = kInfinity) {
    SurfaceInteraction si;
    const Intersector scene({shape}, {});
    const Ray ray{origin, normalize(direction), tMax};
    const bool found = scene.intersect(ray, si);
    EXPECT_EQ(found, scene.occluded(ray));
    return !found;
}

TEST(Shapes, SphereFollowsMitsubasParameters) {
    const ShapePtr sphere = makeSphere(Transform(), {1, 2, 3}, 2, false);
    const SurfaceInteraction si = hit(sphere, {1, 10, 3}, {0, -1, 0});
    expectNear(si.p, {1, 4, 3}, 1e-6f, "p");
    expectNear(si.ng, {0, 1, 0}, 1e-6f, "ng");
    EXPECT_NEAR(si.uv.x, 0.25, 1e-6);  // angle around z from x
    EXPECT_NEAR(si.uv.y, 0.5, 1e-6);   // angle from +z
    expectNear(partials(si).dpdu, {-4 * kPi, 0, 0}, 1e-5f, "dpdu");
    expectNear(partials(si).dpdv, {0, 0, -2 * kPi}, 1e-5f, "dpdv");
    EXPECT_NEAR(sphere->area(), 16 * kPi, 1e-3);
    // From inside, the far side is hit and the normal still points outside.
    const SurfaceInteraction inside = hit(sphere, {1, 2, 3}, {0, 0, 1});
    expectNear(inside.p, {1, 2, 5}, 1e-6f, "p inside");
    expectNear(inside.ng, {0, 0, 1}, 1e-6f, "ng inside");
    EXPECT_NEAR(inside.uv.y, 0, 1e-6);
    expectNear(hit(makeSphere(Transform(), {1, 2, 3}, 2, true), {1, 10, 3}, {0, -1, 0}).ng, {0, -1, 0}, 1e-6f,
               "flipped");
    EXPECT_TRUE(misses(sphere, {1, 10, 3}, {0, 1, 0}));
    EXPECT_TRUE(misses(sphere, {1, 10, 5.01f}, {0, -1, 0}));
    EXPECT_TRUE(misses(sphere, {1, 10, 3}, {0, -1, 0}, 5.9f));
    EXPECT_FALSE(misses(sphere, {1, 10, 3}, {0, -1, 0}, 6.1f));
}

TEST(Shapes, SphereUnderMaps) {
    const ShapePtr sphere = makeSphere(similarity(), {0, 0, 0}, 0.5f, false);
    EXPECT_NEAR(sphere->area(), 4 * kPi, 1e-3);
    // Mitsuba turns the normals of a mirrored sphere.
    const ShapePtr mirrored = makeSphere(Transform::scale({1, 1, -1}), {0, 0, 0}, 1, false);
    expectNear(hit(mirrored, {0, 0, 5}, {0, 0, -1}).ng, {0, 0, -1}, 1e-6f, "mirrored");
    EXPECT_THROW(makeSphere(Transform::scale({1, 2, 1}), {0, 0, 0}, 1, false), Error);
    EXPECT_THROW(makeSphere(Transform(), {0, 0, 0}, 0, false), Error);
    EXPECT_THROW(makeSphere(Transform(), {0, 0, 0}, -1, false), Error);
    EXPECT_THROW(makeSphere(Transform(), {0, 0, 0}, NAN, false), Error);
}

TEST(Shapes, DiskAndEllipse) {
    const ShapePtr disk = makeDisk(Transform(), false);
    const SurfaceInteraction si = hit(disk, {0, 0.5f, 3}, {0, 0, -1});
    expectNear(si.p, {0, 0.5f, 0}, 1e-6f, "p");
    expectNear(si.ng, {0, 0, 1}, 1e-6f, "ng");
    EXPECT_NEAR(si.uv.x, 0.5, 1e-6);   // radius
    EXPECT_NEAR(si.uv.y, 0.25, 1e-6);  // angle
    EXPECT_NEAR(disk->area(), kPi, 1e-5);
    EXPECT_TRUE(misses(disk, {0, 1.001f, 3}, {0, 0, -1}));
    EXPECT_TRUE(misses(disk, {0, 0.5f, 3}, {0, 1, 0}));
    expectNear(hit(makeDisk(Transform(), true), {0, 0, 3}, {0, 0, -1}).ng, {0, 0, -1}, 1e-6f, "flipped");
    const ShapePtr ellipse = makeDisk(Transform::scale({2, 3, 1}), false);
    EXPECT_NEAR(ellipse->area(), 6 * kPi, 1e-4);
    EXPECT_FALSE(misses(ellipse, {0, 2.9f, 3}, {0, 0, -1}));
    EXPECT_TRUE(misses(ellipse, {2.1f, 0, 3}, {0, 0, -1}));
    // The normal follows the inverse transpose when the map mirrors.
    expectNear(hit(makeDisk(Transform::scale({-1, 1, 1}), false), {0, 0, 3}, {0, 0, -1}).ng, {0, 0, 1}, 1e-6f,
               "mirror x");
    expectNear(hit(makeDisk(Transform::scale({1, 1, -1}), false), {0, 0, 3}, {0, 0, -1}).ng, {0, 0, -1},
               1e-6f, "mirror z");
}

TEST(Shapes, CylinderHasNoCaps) {
    const ShapePtr cylinder = makeCylinder(Transform(), {0, 0, -1}, {0, 0, 3}, 2, false);
    EXPECT_NEAR(cylinder->area(), 16 * kPi, 1e-3);
    const SurfaceInteraction si = hit(cylinder, {0, 10, 1}, {0, -1, 0});
    expectNear(si.p, {0, 2, 1}, 1e-6f, "p");
    expectNear(si.ng, {0, 1, 0}, 1e-6f, "ng");
    EXPECT_NEAR(si.uv.x, 0.25, 1e-6);
    EXPECT_NEAR(si.uv.y, 0.5, 1e-6);
    expectNear(partials(si).dpdv, {0, 0, 4}, 1e-5f, "dpdv");
    EXPECT_TRUE(misses(cylinder, {0, 0, 10}, {0, 0, -1}));
    EXPECT_TRUE(misses(cylinder, {0, 10, 3.01f}, {0, -1, 0}));
    // Through the open end onto the inside of the far wall.
    const SurfaceInteraction inside = hit(cylinder, {0, 3, 5}, {0, -1, -1});
    expectNear(inside.p, {0, -2, 0}, 1e-5f, "inside");
    expectNear(inside.ng, {0, -1, 0}, 1e-6f, "ng inside");
    expectNear(hit(makeCylinder(Transform(), {0, 0, 0}, {0, 0, 1}, 1, true), {0, 9, 0.5f}, {0, -1, 0}).ng,
               {0, -1, 0}, 1e-6f, "flipped");
    EXPECT_THROW(makeCylinder(Transform(), {1, 1, 1}, {1, 1, 1}, 1, false), Error);
    EXPECT_THROW(makeCylinder(Transform(), {0, 0, 0}, {0, 0, 1}, 0, false), Error);
    EXPECT_THROW(makeCylinder(Transform::scale({1, 2, 1}), {0, 0, 0}, {0, 0, 1}, 1, false), Error);
}

TEST(Shapes, RectangleFollowsTheInverseTransposeWhenMirrored) {
    const ShapePtr rectangle = makeRectangle(Transform(), false);
    const SurfaceInteraction si = hit(rectangle, {0.5f, -0.5f, 2}, {0, 0, -1});
    expectNear(si.ng, {0, 0, 1}, 1e-6f, "ng");
    EXPECT_NEAR(si.uv.x, 0.75, 1e-6);
    EXPECT_NEAR(si.uv.y, 0.25, 1e-6);
    expectNear(partials(si).dpdu, {2, 0, 0}, 1e-6f, "dpdu");
    expectNear(partials(si).dpdv, {0, 2, 0}, 1e-6f, "dpdv");
    EXPECT_NEAR(rectangle->area(), 4, 1e-5);
    const SurfaceInteraction mirrored =
        hit(makeRectangle(Transform::scale({-1, 1, 1}), false), {0.5f, -0.5f, 2}, {0, 0, -1});
    expectNear(mirrored.ng, {0, 0, 1}, 1e-6f, "mirrored");
    EXPECT_NEAR(mirrored.uv.x, 0.25, 1e-6);
    expectNear(hit(makeRectangle(Transform(), true), {0, 0, 2}, {0, 0, -1}).ng, {0, 0, -1}, 1e-6f, "flipped");
}

TEST(Shapes, CubeNormalsPointOutside) {
    for (const Transform& map : {Transform(), Transform::scale({-1, 1, 1}), similarity()}) {
        const ShapePtr cube = makeCube(map, false);
        const Vec3f center = map.point(Vec3f(0.0f));
        CounterRng rng(hashKey(1));
        for (int i = 0; i < 200; ++i) {
            const SurfaceInteraction si = cube->sampleArea(rng.next2D()).si;
            checkFrame(si);
            EXPECT_GT(dot(si.p - center, si.ng), 0);
            EXPECT_TRUE(si.uv.x >= 0 && si.uv.x <= 1 && si.uv.y >= 0 && si.uv.y <= 1);
        }
    }
    EXPECT_NEAR(makeCube(Transform(), false)->area(), 24, 1e-4);
    EXPECT_NEAR(makeCube(Transform::scale({1, 2, 3}), false)->area(), 8 * (2 + 3 + 6), 1e-3);
}

TEST(Shapes, ProjectiveMapsAreRefused) {
    const Transform projective =
        Transform::fromRows({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0.5, 1}});
    EXPECT_THROW(makeSphere(projective, {0, 0, 0}, 1, false), Error);
    EXPECT_THROW(makeDisk(projective, false), Error);
    EXPECT_THROW(makeRectangle(projective, false), Error);
}

struct Named {
    const char* name;
    ShapePtr shape;
};
std::vector<Named> allShapes() {
    return {
        {"sphere", makeSphere(similarity(), {0, 0, 1}, 0.7f, false)},
        {"mirrored sphere", makeSphere(similarity() * Transform::scale({-1, 1, 1}), {0, 0, 1}, 0.7f, false)},
        {"disk", makeDisk(similarity() * Transform::scale({1, 2, 3}), false)},
        {"cylinder", makeCylinder(similarity(), {0.3f, 0, 1}, {1, 2, 0}, 0.7f, false)},
        {"rectangle", makeRectangle(similarity() * Transform::scale({1, 2, 3}), false)},
        {"cube", makeCube(similarity() * Transform::scale({1, 2, 3}), false)}};
}

TEST(Shapes, RaysReturnToSampledPointsAndBoundsHoldThem) {
    for (const auto& [name, shape] : allShapes()) {
        SCOPED_TRACE(name);
        const Intersector scene({shape}, {});
        Vec3f lower, upper, sceneLower, sceneUpper;
        shape->bounds(lower, upper);
        scene.bounds(sceneLower, sceneUpper);
        CounterRng rng(hashKey(2));
        for (int i = 0; i < 2000; ++i) {
            const ShapeSample sample = shape->sampleArea(rng.next2D());
            const SurfaceInteraction& si = sample.si;
            checkFrame(si);
            EXPECT_NEAR(sample.pdfArea * shape->area(), 1, 1e-5);
            for (int k = 0; k < 3; ++k) {
                EXPECT_TRUE(si.p[k] >= lower[k] && si.p[k] <= upper[k]);
                EXPECT_TRUE(si.p[k] >= sceneLower[k] && si.p[k] <= sceneUpper[k]);
            }
            const Vec3f w = Frame::fromNormal(si.ng).toWorld(warp::squareToCosineHemisphere(rng.next2D()));
            if (dot(w, si.ng) < 0.1f) continue;
            SurfaceInteraction found;
            // Start close by, so that no other part of the shape is in the way.
            ASSERT_TRUE(scene.intersect({si.p + w * 0.02f, -w}, found));
            expectNear(found.p, si.p, 1e-5f, "p");
            expectNear(found.ng, si.ng, 1e-4f, "ng");
            EXPECT_LE((found.uv - si.uv).length(), 1e-4f);
            EXPECT_LE((partials(found).dpdu - partials(si).dpdu).length(),
                      1e-3f * partials(si).dpdu.length());
            EXPECT_LE((partials(found).dpdv - partials(si).dpdv).length(),
                      1e-3f * partials(si).dpdv.length());
        }
    }
}

TEST(Shapes, TangentsAreTheDerivativesOfPosition) {
    for (const auto& [name, shape] : allShapes()) {
        SCOPED_TRACE(name);
        const Intersector scene({shape}, {});
        CounterRng rng(hashKey(3));
        int compared = 0;
        for (int i = 0; i < 500; ++i) {
            const SurfaceInteraction a = shape->sampleArea(rng.next2D()).si;
            const Vec3f step = a.s * 2e-3f + cross(a.ns, a.s) * 1e-3f;
            SurfaceInteraction b;
            if (!scene.intersect({a.p + step + a.ng * 0.01f, -a.ng}, b)) continue;
            const Vec2f d = b.uv - a.uv;
            if (d.length() > 0.01f || dot(a.ng, b.ng) < 0.99f) continue;  // across a seam or an edge
            // Mitsuba's dpdv of a disk is per unit of arc on the unit circle.
            const bool disk = std::string(name) == "disk";
            const Vec3f predicted =
                partials(a).dpdu * d.x + partials(a).dpdv * (disk ? d.y * 2 * kPi * a.uv.x : d.y);
            EXPECT_LE((predicted - (b.p - a.p)).length(), 0.05f * (b.p - a.p).length());
            ++compared;
        }
        EXPECT_GT(compared, 300);
    }
}

}  // namespace
}  // namespace metrolux::core
