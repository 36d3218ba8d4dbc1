/// Which pairs of points a wall keeps apart, and which it does not: a pair that is lost without need is lost
/// energy.

#include "transport/merge_walls.h"

#include "base/rng.h"
#include "scattering/mask.h"
#include "scattering/null_bsdf.h"
#include "scattering/thin_dielectric.h"
#include "support/small_scenes.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using namespace test;

constexpr float kRadius = 0.1f;

Vertex at(const SurfaceInteraction& si, const Vec3f& toPrevious) {
    Vertex v;
    v.si = si;
    v.toPrevious = normalize(toPrevious);
    return v;
}

class MergeWalls : public ::testing::Test {
  protected:
    const Scene& scene() {
        if (!scene_) {
            b_.camera({0, 5, 5}, {0, 0, 0}, 50, 8, 8);
            scene_ = b_.build();
        }
        return *scene_;
    }
    ShapePtr add(const ShapePtr& shape) { return b_.add(shape, diffuse(0.5f)); }
    void floor() { add(rectangle({0, 0, 0}, {0, 1, 0}, 4, 4)); }
    /// From the floor up, in the plane of this x.
    void pane(float x, BsdfPtr bsdf, float height = 3, float halfWidth = 4) {
        b_.add(rectangle({x, height / 2, 0}, {1, 0, 0}, halfWidth, height / 2), std::move(bsdf));
    }
    /// Of two points of the floor, lit and seen from above.
    bool between(const Vec3f& light, const Vec3f& eye) {
        SurfaceInteraction a, b;
        a.ng = b.ng = Vec3f(0, 1, 0);
        a.p = light;
        b.p = eye;
        return isWallBetween(scene(), at(a, {0.1f, 1, 0.2f}), at(b, {-0.3f, 1, 0}), kRadius);
    }
    /// The share of pairs that are refused, of those that would be merged: random points of a surface with
    /// normals alike, within the radius. `side`: of the normals that is lit and seen.
    double refused(const Shape& shape, float side, int pairs = 2000) {
        CounterRng rng(7);
        const auto point = [&] { return shape.sampleArea({rng.next1D(), rng.next1D()}).si; };
        int refused = 0, found = 0;
        for (int64_t tried = 0; found < pairs && tried < 20'000'000; ++tried) {
            const SurfaceInteraction a = point(), b = point();
            if (lengthSquared(a.p - b.p) > kRadius * kRadius || dot(a.ng, b.ng) < 0.5f) continue;
            ++found;
            refused += isWallBetween(scene(), at(a, a.ng * side), at(b, b.ng * side), kRadius);
        }
        EXPECT_EQ(found, pairs);
        return double(refused) / pairs;
    }

  private:
    SceneBuilder b_;
    std::shared_ptr<Scene> scene_;
};

/// A mesh from a function of two numbers in [0, 1].
template <class Point>
ShapePtr surface(int n, Point&& point) {
    auto mesh = std::make_shared<TriangleMesh>();
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) mesh->positions.push_back(point(float(i) / n, float(j) / n));
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<uint32_t>(j * (n + 1) + i), b = a + 1, c = a + n + 2, d = a + n + 1;
            mesh->indices.insert(mesh->indices.end(), {a, c, b, a, d, c});
        }
    mesh->finalize();
    return mesh;
}

TEST_F(MergeWalls, AWallKeepsItsTwoSidesApart) {
    floor();
    pane(0, diffuse(0.5f));
    CounterRng rng(1);
    const auto near = [&] { return 1e-3f + 0.04f * rng.next1D(); };
    for (int i = 0; i < 500; ++i) {
        const float z = 6 * rng.next1D() - 3;
        const Vec3f eye(-near(), 0, z), beyond(near(), 0, z + near());
        EXPECT_TRUE(between(beyond, eye)) << beyond.x << " and " << eye.x;
        EXPECT_TRUE(between(eye, beyond)) << beyond.x << " and " << eye.x;
        EXPECT_FALSE(between({-beyond.x, 0, beyond.z}, eye));
    }
}

TEST_F(MergeWalls, NoWayLeadsThroughOtherWalls) {
    // The wall ends at another one, and at a ceiling that is lower than the radius.
    floor();
    pane(0, diffuse(0.5f), 3, 2);
    add(rectangle({0, 0, 2}, {0, 0, -1}, 3, 3));
    add(rectangle({0, 0.05f, 0}, {0, -1, 0}, 3, 3));
    for (const float z : {1.999f, 1.99f, 1.96f, 1.9f, 0.0f})
        EXPECT_TRUE(between({0.02f, 0, z}, {-0.02f, 0, z})) << z;
}

TEST_F(MergeWalls, AWallEndsSomewhere) {
    floor();
    pane(0, diffuse(0.5f), 3, 2);
    EXPECT_TRUE(between({0.02f, 0, 1.9f}, {-0.02f, 0, 1.9f}));
    EXPECT_FALSE(between({0.02f, 0, 1.97f}, {-0.02f, 0, 1.97f}));  // light comes around
}

TEST_F(MergeWalls, WhatTransmitsLightIsNoWall) {
    floor();
    MaskParameters mask;
    mask.nested = diffuse(0.5f);
    pane(-0.02f, makeNullBsdf());
    pane(-0.01f, makeThinDielectric({}));
    pane(0.01f, makeMask(mask));
    pane(0.05f, diffuse(0.5f));
    EXPECT_FALSE(between({0.03f, 0, 0.3f}, {-0.03f, 0, 0.31f}));
    EXPECT_TRUE(between({0.06f, 0, 0.3f}, {-0.03f, 0, 0.31f}));  // the last one is
}

TEST_F(MergeWalls, WhatIsSmallerThanTheRadiusIsNoWall) {
    floor();
    pane(0, diffuse(0.5f), 0.5f * kRadius);                                       // a kerb
    add(makeCylinder(Transform(), {1, 0, 0}, {1, 3, 0}, 0.2f * kRadius, false));  // a post
    EXPECT_FALSE(between({0.02f, 0, 0}, {-0.02f, 0, 0}));
    EXPECT_FALSE(between({1.03f, 0, 0}, {0.97f, 0, 0.01f}));
}

TEST_F(MergeWalls, CurvedSurfacesLoseNothing) {
    // Of 1.2 to 10 merging radii, from outside and from inside.
    std::vector<ShapePtr> shapes;
    for (const float r : {0.12f, 0.3f, 1.0f}) {
        shapes.push_back(add(makeSphere(Transform(), {3 * r, 3 * r, 0}, r, false)));
        shapes.push_back(add(makeCylinder(Transform(), {-3 * r, r, 0}, {-3 * r, 3 * r, 0}, r, false)));
        shapes.push_back(add(surface(12, [&](float u, float v) {
            const float phi = 2 * kPi * u, theta = kPi * (0.1f + 0.8f * v);
            return Vec3f(r * std::sin(theta) * std::cos(phi), r * std::cos(theta) - 4 * r,
                         r * std::sin(theta) * std::sin(phi));
        })));
    }
    for (size_t i = 0; i < shapes.size(); ++i)
        for (const float side : {1.0f, -1.0f})
            EXPECT_EQ(refused(*shapes[i], side), 0) << i << ", side " << side;
}

TEST_F(MergeWalls, EdgesAndCornersLoseNothing) {
    const ShapePtr room = add(makeCube(Transform(), false));
    // A ridge of 50 degrees, a wedge of 20 under a plane, and a stack of two sheets closer than the lift.
    const ShapePtr ridge = add(surface(2, [](float u, float v) {
        return Vec3f(2 * u - 1, 5 - std::abs(2 * u - 1) * std::tan(kPi * 25 / 180), 1 - 2 * v);
    }));
    const ShapePtr wedge = add(rectangle({0.3f, -2, 0}, {0, 1, 0}, 0.3f, 0.3f));
    const float angle = kPi * 20 / 180;
    add(rectangle({std::cos(angle), -2 + std::sin(angle), 0}, {std::sin(angle), -std::cos(angle), 0}, 1, 1));
    const ShapePtr sheet = add(rectangle({0, 12, 0}, {0, 1, 0}, 0.5f, 0.5f));
    add(rectangle({0, 12.002f, 0}, {0, 1, 0}, 0.5f, 0.5f));
    for (const ShapePtr& shape : {room, ridge, wedge, sheet})
        for (const float side : {1.0f, -1.0f}) EXPECT_EQ(refused(*shape, side), 0) << shape->area();
}

TEST_F(MergeWalls, TilesInOnePlaneAreOneSurface) {
    add(rectangle({-1, 0, 0}, {0, 1, 0}, 1, 1));
    add(rectangle({1, 0, 0}, {0, 1, 0}, 1, 1));
    CounterRng rng(3);
    for (int i = 0; i < 500; ++i) {
        const float z = 1.8f * rng.next1D() - 0.9f;
        EXPECT_FALSE(between({0.06f * rng.next1D(), 0, z}, {-0.06f * rng.next1D(), 0, z}));
    }
}

TEST_F(MergeWalls, BumpsAndGrassLoseLittle) {
    // Bumps of a fifth of the radius, up to 45 degrees steep, and 800 blades higher than it, a sixteenth as
    // wide.
    const ShapePtr bumps = add(surface(
        80, [](float u, float v) { return Vec3f(u, 0.02f * std::sin(50 * u) * std::sin(47 * v), 1 - v); }));
    const ShapePtr meadow = add(rectangle({3, 0, 0}, {0, 1, 0}, 0.5f, 0.5f));
    CounterRng rng(5);
    for (int i = 0; i < 800; ++i) {
        const float phi = 2 * kPi * rng.next1D();
        add(rectangle({2.5f + rng.next1D(), 0.2f, rng.next1D() - 0.5f}, {std::cos(phi), 0, std::sin(phi)},
                      0.003f, 0.2f));
    }
    EXPECT_EQ(refused(*bumps, 1), 0);
    EXPECT_LT(refused(*meadow, 1), 0.05);
}

}  // namespace
}  // namespace metrolux::core
