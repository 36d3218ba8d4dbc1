#include "base/warp.h"

#include "base/frame.h"
#include "base/rng.h"
#include "support/goodness_of_fit.h"

#include <gtest/gtest.h>

#include <functional>

namespace metrolux::core {
namespace {

constexpr int kSamples = 200000, kBins = 24;

/// Uniformity of coordinates that the test derives from samples such that they should be uniform on the unit
/// square.
void expectUniform(const std::function<Vec2f(const Vec2f&)>& coordinates, uint64_t seed) {
    std::vector<double> counts(kBins * kBins);
    CounterRng rng(seed);
    for (int i = 0; i < kSamples; ++i) {
        const Vec2f c = coordinates({rng.next1D(), rng.next1D()});
        ASSERT_TRUE(c.x > -1e-5f && c.x < 1 + 1e-5f && c.y > -1e-5f && c.y < 1 + 1e-5f) << c.x << " " << c.y;
        const auto bin = [](float x) { return std::clamp(static_cast<int>(x * kBins), 0, kBins - 1); };
        counts[bin(c.y) * kBins + bin(c.x)] += 1;
    }
    EXPECT_GT(test::chiSquarePValue(counts), test::kLevel);
}

float azimuth(float x, float y) { return 0.5f + std::atan2(y, x) / (2 * kPi); }

TEST(Warp, SineAndCosineNearZeroAreThoseOfTheLibrary) {
    for (int i = -100000; i <= 100000; ++i) {
        const float x = static_cast<float>(i) * (kPi / 4) / 100000;
        float sine, cosine;
        warp::sinCosNearZero(x, sine, cosine);
        ASSERT_NEAR(sine, std::sin(double(x)), 1e-7) << x;
        ASSERT_NEAR(cosine, std::cos(double(x)), 1e-7) << x;
    }
}

/// The map of Shirley and Chiu: squares around the middle become circles, diagonals stay where they are.
TEST(Warp, DiskIsConcentric) {
    CounterRng rng(5);
    for (int i = 0; i < 10000; ++i) {
        const Vec2f u = rng.next2D(), p = warp::squareToDisk(u);
        const float x = 2 * u.x - 1, y = 2 * u.y - 1;
        EXPECT_NEAR(p.length(), std::max(std::abs(x), std::abs(y)), 1e-6f);
        EXPECT_GE(p.x * x, 0);
        EXPECT_GE(p.y * y, 0);
        const Vec2f diagonal = warp::squareToDisk({u.x, u.x});
        EXPECT_NEAR(diagonal.x, diagonal.y, 1e-6f);
    }
    EXPECT_EQ(warp::squareToDisk({0.5f, 0.5f}), Vec2f(0.0f));
}

TEST(Warp, DiskIsUniform) {
    expectUniform(
        [](const Vec2f& u) {
            const Vec2f p = warp::squareToDisk(u);
            return Vec2f(p.x * p.x + p.y * p.y, azimuth(p.x, p.y));
        },
        1);
}

TEST(Warp, DiskKeepsNeighborsTogether) {
    // Concentric map: shells of the square become shells of the disk.
    EXPECT_EQ(warp::squareToDisk({0.5f, 0.5f}), Vec2f(0, 0));
    for (int i = 0; i < 100; ++i) {
        const Vec2f p = warp::squareToDisk({0.75f, 0.25f + 0.005f * static_cast<float>(i)});
        EXPECT_NEAR(std::hypot(p.x, p.y), 0.5f, 1e-6f);
    }
}

TEST(Warp, CosineHemisphereFollowsItsDensity) {
    // sin^2 is uniform where the density per solid angle is cos / pi.
    expectUniform(
        [](const Vec2f& u) {
            const Vec3f v = warp::squareToCosineHemisphere(u);
            return Vec2f(v.x * v.x + v.y * v.y, azimuth(v.x, v.y));
        },
        2);
    EXPECT_FLOAT_EQ(warp::cosineHemispherePdf({0, 0, 1}), kInvPi);
    EXPECT_EQ(warp::cosineHemispherePdf({0, 0, -1}), 0);
}

TEST(Warp, SphereIsUniform) {
    expectUniform(
        [](const Vec2f& u) {
            const Vec3f v = warp::squareToSphere(u);
            return Vec2f(0.5f + 0.5f * v.z, azimuth(v.x, v.y));
        },
        3);
}

TEST(Warp, ConesAreUniformHoweverNarrow) {
    for (const float oneMinusCos : {2.0f, 1.0f, 0.1f, 1e-4f, 1e-9f}) {
        expectUniform(
            [&](const Vec2f& u) {
                const Vec3f v = warp::squareToCone(u, oneMinusCos);
                // 1 - cos from the sine: keeps digits in narrow cones; beyond a right angle from the cosine.
                const double s2 = double(v.x) * v.x + double(v.y) * v.y;
                const double d = v.z > 0.5f ? s2 / (1 + std::sqrt(std::max(0.0, 1 - s2))) : 1 - double(v.z);
                return Vec2f(static_cast<float>(d / oneMinusCos), azimuth(v.x, v.y));
            },
            4);
        EXPECT_NEAR(warp::uniformConePdf(oneMinusCos) * 2 * kPi * oneMinusCos, 1, 1e-6);
    }
}

TEST(Warp, TriangleIsUniform) {
    // Of a uniform point, (1 - b0')^2 with b0' = 1 - b1 and b2 / (1 - b1) are uniform.
    expectUniform(
        [](const Vec2f& u) {
            const Vec2f b = warp::squareToTriangle(u);
            const float rest = 1 - b.x;
            return Vec2f(rest * rest, rest > 0 ? b.y / rest : 0);
        },
        5);
}

TEST(Warp, CornersOfTheSquareStayInTheDomain) {
    for (const float x : {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon})
        for (const float y : {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon}) {
            const Vec2f u(x, y), d = warp::squareToDisk(u), b = warp::squareToTriangle(u);
            EXPECT_LE(std::hypot(d.x, d.y), 1 + 1e-6f);
            EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1 + 1e-6f);
            EXPECT_GT(warp::squareToCosineHemisphere(u).z, 0);
            for (const Vec3f& v :
                 {warp::squareToCosineHemisphere(u), warp::squareToSphere(u), warp::squareToCone(u, 0.3f)})
                EXPECT_NEAR(v.length(), 1, 1e-5f);
        }
}

void expectOrthonormal(const Frame& f) {
    EXPECT_NEAR(f.s.length(), 1, 2e-6f);
    EXPECT_NEAR(f.t.length(), 1, 2e-6f);
    EXPECT_NEAR(dot(f.s, f.t), 0, 2e-6f);
    EXPECT_NEAR(dot(f.s, f.n), 0, 2e-6f);
    EXPECT_NEAR(dot(f.t, f.n), 0, 2e-6f);
    EXPECT_GT(dot(cross(f.s, f.t), f.n), 0.999f);  // right-handed
}

TEST(Frame, IsOrthonormalAroundAnyNormal) {
    CounterRng rng(6);
    std::vector<Vec3f> normals = {{0, 0, 1},
                                  {0, 0, -1},
                                  {1, 0, 0},
                                  {0, -1, 0},
                                  {1, 0, -0.0f},
                                  normalize(Vec3f(1e-4f, 0, -1)),
                                  normalize(Vec3f(1e-7f, 1e-7f, -1))};
    for (int i = 0; i < 1000; ++i) normals.push_back(warp::squareToSphere(rng.next2D()));
    for (const Vec3f& n : normals) {
        const Frame f = Frame::fromNormal(n);
        expectOrthonormal(f);
        const Vec3f v = warp::squareToSphere(rng.next2D());
        EXPECT_NEAR((f.toWorld(f.toLocal(v)) - v).length(), 0, 2e-6f);
        EXPECT_NEAR(cosTheta(f.toLocal(v)), dot(v, n), 2e-6f);
    }
}

TEST(Frame, FollowsTheTangentWhereThereIsOne) {
    CounterRng rng(7);
    for (int i = 0; i < 1000; ++i) {
        const Vec3f n = warp::squareToSphere(rng.next2D());
        const Vec3f tangent = warp::squareToSphere(rng.next2D()) * std::exp(20 * (rng.next1D() - 0.5f));
        const Frame f = Frame::fromNormalAndTangent(n, tangent);
        expectOrthonormal(f);
        EXPECT_GT(dot(f.s, tangent), 0);
        EXPECT_NEAR(dot(f.t, tangent) / tangent.length(), 0, 1e-5f);
    }
    const Vec3f n(0, 0, 1);
    for (const Vec3f& useless : {Vec3f(0.0f), n, n * -3.0f, Vec3f(1e-9f, 0, 1), Vec3f(1e-30f, 0, 0)})
        expectOrthonormal(Frame::fromNormalAndTangent(n, useless));
}

}  // namespace
}  // namespace metrolux::core
