#include "base/transform.h"

#include "base/error.h"
#include "base/rng.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

void expectNear(const Vec3f& a, const Vec3f& b, float tolerance = 1e-6f) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

Vec3f randomVector(CounterRng& rng) {
    return {2 * rng.next1D() - 1, 2 * rng.next1D() - 1, 2 * rng.next1D() - 1};
}

Transform randomAffine(CounterRng& rng) {
    const Vec3f factors(0.3f + rng.next1D(), 0.3f + rng.next1D(), -0.3f - rng.next1D());
    return Transform::translate(randomVector(rng)) *
           Transform::rotate(randomVector(rng), 360 * rng.nextDouble()) * Transform::scale(factors) *
           Transform::rotate(randomVector(rng), 360 * rng.nextDouble());
}

TEST(Transform, ConventionsOfTheBasicMaps) {
    const Vec3f p(1, 2, 3);
    expectNear(Transform().point(p), p);
    EXPECT_TRUE(Transform().isIdentity());
    expectNear(Transform::translate({10, 0, -1}).point(p), {11, 2, 2});
    expectNear(Transform::translate({10, 0, -1}).vector(p), p);
    expectNear(Transform::scale({2, 3, -1}).point(p), {2, 6, -3});
    // Right-hand rule: around z, x turns to y; the axis need not be of unit length.
    expectNear(Transform::rotate({0, 0, 5}, 90).point({1, 0, 0}), {0, 1, 0});
    expectNear(Transform::rotate({1, 0, 0}, 90).point({0, 1, 0}), {0, 0, 1});
    expectNear(Transform::rotate({0, 1, 0}, 90).point({0, 0, 1}), {1, 0, 0});
    expectNear(Transform::rotate({1, 1, 1}, 120).point({1, 0, 0}), {0, 1, 0});
}

TEST(Transform, ProductAppliesTheRightFactorFirst) {
    const Transform a = Transform::translate({1, 0, 0}), b = Transform::rotate({0, 0, 1}, 90);
    expectNear((a * b).point({1, 0, 0}), {1, 1, 0});
    expectNear((b * a).point({1, 0, 0}), {0, 2, 0});
}

TEST(Transform, InverseUndoesPointsAndVectors) {
    CounterRng rng(1);
    for (int i = 0; i < 200; ++i) {
        const Transform t = randomAffine(rng), inverse = t.inverse();
        const Vec3f p = randomVector(rng);
        expectNear(inverse.point(t.point(p)), p, 1e-5f);
        expectNear(t.point(inverse.point(p)), p, 1e-5f);
        expectNear(inverse.vector(t.vector(p)), p, 1e-5f);
        expectNear((t * inverse).point(p), p, 1e-5f);
        EXPECT_NEAR(t.determinant3() * inverse.determinant3(), 1.0, 1e-6);
        EXPECT_LT(t.determinant3(), 0);  // one negative factor
    }
}

TEST(Transform, VerySmallAndVeryUnequalScalesAreNotSingular) {
    for (const Vec3f& s : {Vec3f(1e-12f), Vec3f(1e12f), Vec3f(1e-8f, 1, 1e8f)}) {
        const Transform t = Transform::translate({3, 4, 5}) * Transform::scale(s);
        expectNear(t.inverse().point(t.point({0, 0, 0})), {0, 0, 0});
        expectNear(t.inverse().vector(t.vector({1, 1, 1})), {1, 1, 1}, 1e-5f);
    }
}

TEST(Transform, NormalsStayPerpendicularToTransformedTangents) {
    CounterRng rng(2);
    for (int i = 0; i < 200; ++i) {
        const Transform t = randomAffine(rng);
        const Vec3f a = randomVector(rng), b = randomVector(rng);
        if (cross(a, b).length() < 1e-2f) continue;
        const Vec3f n = normalize(t.normal(normalize(cross(a, b))));
        EXPECT_NEAR(dot(n, normalize(t.vector(a))), 0, 2e-5f);
        EXPECT_NEAR(dot(n, normalize(t.vector(b))), 0, 2e-5f);
    }
    // A reflection keeps the normal of the mirror's plane pointing with the reflected points.
    expectNear(Transform::scale({1, 1, -1}).normal({0, 0, 1}), {0, 0, -1});
}

TEST(Transform, LookAtPutsTheTargetOnPositiveZAndTheLeftOfTheImageOnPositiveX) {
    const Transform t = Transform::lookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
    expectNear(t.point({0, 0, 0}), {0, 0, 5});
    expectNear(t.vector({0, 0, 1}), {0, 0, -1});
    expectNear(t.vector({0, 1, 0}), {0, 1, 0});
    expectNear(t.vector({1, 0, 0}), {-1, 0, 0});  // who looks along -z has -x at the left

    CounterRng rng(3);
    for (int i = 0; i < 100; ++i) {
        const Vec3f origin = randomVector(rng), target = randomVector(rng), up = randomVector(rng);
        if (cross(normalize(up), normalize(target - origin)).length() < 1e-2f) continue;
        const Transform m = Transform::lookAt(origin, target, up);
        expectNear(m.vector({0, 0, 1}), normalize(target - origin), 1e-5f);
        EXPECT_GT(dot(m.vector({0, 1, 0}), up), 0);
        EXPECT_NEAR(dot(m.vector({1, 0, 0}), up), 0, 1e-5f);
        EXPECT_NEAR(m.determinant3(), 1.0, 1e-5);
        EXPECT_FALSE(m.hasScale());
    }
}

TEST(Transform, ProjectiveMapsDivide) {
    const double rows[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 1, 0.5}};
    const Transform t = Transform::fromRows(rows);
    expectNear(t.point({2, 4, 1.5f}), {1, 2, 0.75f});
    expectNear(t.inverse().point(t.point({2, 4, 1.5f})), {2, 4, 1.5f});
}

TEST(Transform, HasScaleIgnoresRotationsAndRounding) {
    EXPECT_FALSE(Transform::rotate({1, 2, 3}, 33).hasScale());
    EXPECT_FALSE(Transform::scale({1.0005f, 1, 1}).hasScale());
    EXPECT_TRUE(Transform::scale({1, 1.002f, 1}).hasScale());
    EXPECT_FALSE(Transform::scale({1, -1, 1}).hasScale());
    EXPECT_TRUE(Transform::scale({0.5f, 0.5f, 0.5f}).hasScale());
}

TEST(Transform, SingularMapsHaveNoInverse) {
    const double dependent[4][4] = {{1, 2, 3, 0}, {2, 4, 6, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    const double zeroRow[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 0}};
    for (const Transform& t :
         {Transform::scale({1, 0, 1}), Transform::fromRows(dependent), Transform::fromRows(zeroRow)}) {
        EXPECT_TRUE(t.isSingular());
        EXPECT_TRUE((t * Transform::scale({2, 2, 2})).isSingular());
        EXPECT_TRUE((Transform::rotate({1, 2, 3}, 40) * t).isSingular());
        EXPECT_THROW(t.inverse(), Error);
    }
    EXPECT_FALSE(Transform::scale({2, 2, 2}).isSingular());
}

TEST(Transform, NormalsOfAFlattenedSpaceAreThoseOfThePlane) {
    // Flattened onto y = 0, then turned so that +y becomes +z.
    const Transform flat = Transform::scale({1, 0, 1}), turn = Transform::rotate({1, 0, 0}, 90);
    expectNear(flat.normal({0, 1, 0}), {0, 1, 0});
    expectNear(flat.normal({1, 0, 0}), {0, 0, 0});
    expectNear((turn * flat).normal({0, 1, 0}), {0, 0, 1});
    expectNear((turn * flat * Transform::scale({2, 1, 1})).normal({0, 1, 0}), {0, 0, 2});
    EXPECT_EQ(Transform::scale({0, 0, 1}).normal({1, 2, 3}), Vec3f(0, 0, 0));
}

TEST(Transform, NoAxisIsNeededToRotateByNothing) {
    EXPECT_TRUE(Transform::rotate({0, 0, 0}, 0).isIdentity());
}

TEST(Transform, WhatHasNoDirectionIsRefused) {
    EXPECT_THROW(Transform::rotate({0, 0, 0}, 10), Error);
    EXPECT_THROW(Transform::lookAt({1, 2, 3}, {1, 2, 3}, {0, 1, 0}), Error);
    EXPECT_THROW(Transform::lookAt({0, 0, 0}, {0, 3, 0}, {0, 1, 0}), Error);
    EXPECT_THROW(Transform::lookAt({0, 0, 0}, {0, 0, 1}, {0, 0, 0}), Error);
}

TEST(Transform, NumbersThatAreNotFiniteAreRefused) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(Transform::translate({nan, 0, 0}), Error);
    EXPECT_THROW(Transform::scale({kInfinity, 1, 1}), Error);
    EXPECT_THROW(Transform::rotate({0, 0, 1}, std::numeric_limits<double>::infinity()), Error);
    EXPECT_THROW(Transform::rotate({nan, 0, 1}, 10), Error);
    EXPECT_THROW(Transform::lookAt({nan, 0, 0}, {0, 0, 1}, {0, 1, 0}), Error);
    EXPECT_THROW(Transform::lookAt({0, 0, 0}, {0, 0, kInfinity}, {0, 1, 0}), Error);
}

}  // namespace
}  // namespace metrolux::core
