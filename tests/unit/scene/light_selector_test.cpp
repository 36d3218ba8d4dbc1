/// Choice of a light by a tree: a distribution, reported to the bit, in whose support is every light that
/// arrives.

#include "scene/light_selector.h"

#include "base/error.h"
#include "support/goodness_of_fit.h"
#include "support/many_lights.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using test::ManyLights;
using test::mixedLights;
using test::randomPlace;
using test::randomPoint;

constexpr float kExtent = 10;

LightSelector selector(const ManyLights& many, const Vec3f& center = Vec3f(0.0f)) {
    const SceneBounds scene{center, 2 * kExtent};
    for (const LightPtr& light : many.lights) light->setSceneBounds(scene);
    return LightSelector(many.lights, scene);
}

void addInfinite(ManyLights& many) {
    many.lights.push_back(makeDirectionalLight({{0.3f, -2, 0.5f}, Rgb(0.5f)}));
    many.lights.insert(many.lights.begin() + 1, makeConstantLight({Rgb(0.2f)}));
}

/// Points among the lights, on them, near and far.
std::vector<Vec3f> points(const ManyLights& many, const Vec3f& center = Vec3f(0.0f)) {
    std::vector<Vec3f> result;
    CounterRng rng(hashKey(77));
    for (const float extent : {0.1f, 1.0f, 1.5f, 100.0f, 1e6f})
        for (int i = 0; i < 4; ++i) result.push_back(center + randomPoint(rng, extent * kExtent));
    for (size_t i = 0; i < many.lights.size() && i < 12; ++i)
        if (const std::optional<LightBounds> b = many.lights[i]->bounds()) {
            result.push_back(b->lower);
            result.push_back((b->lower + b->upper) * 0.5f);
        }
    return result;
}

double sumOfProbabilities(const LightSelector& s, size_t count, const Vec3f& x) {
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const float p = s.probability(x, i);
        EXPECT_TRUE(p >= 0 && p <= 1) << p;
        sum += p;
    }
    return sum;
}

/// Samples at x: they follow probability(), and report it; `u` is uniform again after the choice.
void expectSamplesFollow(const LightSelector& s, size_t count, const Vec3f& x, int samples, uint64_t seed) {
    constexpr size_t kCells = 16;
    std::vector<double> observed(count), expected(count), rest(kCells);
    for (uint32_t i = 0; i < count; ++i) expected[i] = double(samples) * s.probability(x, i);
    CounterRng rng(hashKey(seed));
    for (int k = 0; k < samples; ++k) {
        float u = rng.next1D();
        const LightSelector::Choice c = s.sample(x, u);
        ASSERT_LT(c.light, count);
        ASSERT_EQ(c.probability, s.probability(x, c.light)) << "to the bit";
        ASSERT_GT(c.probability, 0);
        ASSERT_TRUE(u >= 0 && u < 1) << u;
        observed[c.light] += 1;
        rest[static_cast<size_t>(u * kCells)] += 1;
    }
    EXPECT_GT(test::chiSquarePValue(observed, expected), test::kLevel) << x;
    EXPECT_GT(test::chiSquarePValue(rest), test::kLevel) << x;
}

TEST(LightSelector, IsADistributionAtEveryPoint) {
    for (const int count : {1, 2, 7, 8, 9, 65, 600})
        for (const bool infinite : {false, true}) {
            ManyLights many = mixedLights(count, 1);
            if (infinite) addInfinite(many);
            const LightSelector s = selector(many);
            for (const Vec3f& x : points(many))
                EXPECT_NEAR(sumOfProbabilities(s, many.lights.size(), x), 1, 1e-5)
                    << count << " at " << x << (infinite ? ", infinite lights too" : "");
        }
}

TEST(LightSelector, SamplesFollowIt) {
    for (const int count : {2, 9, 70, 300})
        for (const bool infinite : {false, true}) {
            ManyLights many = mixedLights(count, 2);
            if (infinite) addInfinite(many);
            const LightSelector s = selector(many);
            CounterRng rng(hashKey(3));
            for (int i = 0; i < 6; ++i)
                expectSamplesFollow(s, many.lights.size(), randomPoint(rng, kExtent * (i < 4 ? 1.0f : 5.0f)),
                                    20000, 10 + i);
        }
}

TEST(LightSelector, ReachesEveryLightThatArrives) {
    // Lights apart, lights within each other, and far from the origin.
    struct Case {
        float center, extent, size;
    };
    for (const Case& c : {Case{0, kExtent, 0.5f}, Case{0, 1, 3}, Case{3000, kExtent, 1}}) {
        const Vec3f center(c.center, -c.center, 0.3f * c.center);
        ManyLights many = mixedLights(200, 5, center, c.extent, c.size);
        addInfinite(many);
        const LightSelector s = selector(many, center);
        CounterRng rng(hashKey(6));
        int arrived = 0;
        for (int k = 0; k < 2000; ++k) {
            const Vec3f x = center + randomPoint(rng, (k % 2 == 0 ? 1.0f : 0.2f) * kExtent);
            for (int j = 0; j < 12; ++j) {
                const auto i = std::min(static_cast<size_t>(rng.next1D() * float(many.lights.size())),
                                        many.lights.size() - 1);
                const std::optional<EndpointConnection> found = many.lights[i]->connect(x, rng.next2D());
                if (!found || isBlack(found->value)) continue;
                ++arrived;
                ASSERT_GT(s.probability(x, static_cast<uint32_t>(i)), 0) << "light " << i << " at " << x;
            }
        }
        EXPECT_GT(arrived, 5000);
    }
}

TEST(LightSelector, ReachesAllThatShineAlongARow) {
    // Lamps in a row that look along it: what is beside the row is lit by those behind it, up to its own
    // place.
    ManyLights many;
    constexpr int kLamps = 200;
    for (int i = 0; i < kLamps; ++i)
        many.area(makeDisk(Transform::translate({static_cast<float>(i) / kLamps, 0, 0}) *
                               Transform::rotate({0, 1, 0}, 90) * Transform::scale(Vec3f(1e-4f)),
                           false),
                  Rgb(1.0f));
    const LightSelector s = selector(many);
    int arrived = 0;
    for (const float side : {0.01f, 0.3f, 1.0f, 3.0f})
        for (int k = 0; k < kLamps; k += 3) {
            const Vec3f x((static_cast<float>(k) + 0.5f) / kLamps, side, 0);
            for (uint32_t i = 0; i < many.lights.size(); ++i) {
                if (!many.lights[i]->connect(x, {0.5f, 0.5f})) continue;
                ++arrived;
                ASSERT_GT(s.probability(x, i), 0) << "lamp " << i << " at " << x;
            }
        }
    EXPECT_GT(arrived, 20000);
}

TEST(LightSelector, ReachesFlatLampsThatLookSeveralWays) {
    // Pairs side by side that look apart by up to 180 degrees, far from each other: a cluster's cone holds
    // both.
    ManyLights many;
    CounterRng rng(hashKey(12));
    for (int i = 0; i < 200; ++i) {
        const Vec3f place(static_cast<float>(i / 2 * 10), 0, static_cast<float>(i % 2) * 0.1f);
        many.area(makeDisk(Transform::translate(place) * randomPlace(rng, Vec3f(0.0f), 0) *
                               Transform::scale(Vec3f(0.01f)),
                           false),
                  Rgb(1.0f));
    }
    const LightSelector s = selector(many);
    int arrived = 0;
    for (int k = 0; k < 2000; ++k) {
        const Vec3f x = Vec3f(500, 0, 0) + randomPoint(rng, 500);
        for (uint32_t i = static_cast<uint32_t>(k % 7); i < many.lights.size(); i += 7) {
            if (!many.lights[i]->connect(x, {0.5f, 0.5f})) continue;
            ++arrived;
            ASSERT_GT(s.probability(x, i), 0) << "lamp " << i << " at " << x;
        }
    }
    EXPECT_GT(arrived, 10000);
}

TEST(LightSelector, NeverTakesLightsThatCannotBeConnected) {
    ManyLights many = mixedLights(3, 7);
    many.lights.insert(many.lights.begin(), makeCollimatedLight({Transform(), Rgb(1e6f)}));
    const LightSelector s = selector(many);
    EXPECT_EQ(s.probability(Vec3f(0.0f), 0), 0);
    EXPECT_NEAR(sumOfProbabilities(s, many.lights.size(), Vec3f(0.0f)), 1, 1e-6);
    expectSamplesFollow(s, many.lights.size(), Vec3f(0.0f), 5000, 1);

    ManyLights beam;
    beam.lights.push_back(makeCollimatedLight({Transform(), Rgb(1.0f)}));
    EXPECT_TRUE(selector(beam).empty());
    EXPECT_TRUE(selector({}).empty());
}

TEST(LightSelector, OneLightCostsNoChoice) {
    for (const int kind : {0, 7, 8}) {
        ManyLights many = mixedLights(kind + 1, 8);
        many.lights = {many.lights.back()};
        const LightSelector s = selector(many);
        float u = 0.37f;
        EXPECT_EQ(s.sample({1, 2, 3}, u).probability, 1);
        EXPECT_EQ(u, 0.37f);
        EXPECT_EQ(s.probability({-1, 2, 3}, 0), 1);
    }
}

TEST(LightSelector, HalfOfTheChoiceBetweenPlacedAndInfiniteLightsIsByIrradiance) {
    // A lamp that sends 1 to the origin, and a light from infinity of irradiance 3: 1/4 + 3/8.
    ManyLights many;
    many.lights = {makePointLight({{0, 2, 0}, Rgb(4)}), makeDirectionalLight({{0, -1, 0}, Rgb(3)})};
    const LightSelector s = selector(many);
    EXPECT_NEAR(s.probability(Vec3f(0.0f), 1), 0.625, 1e-5);
    EXPECT_NEAR(s.probability(Vec3f(0.0f), 0), 0.375, 1e-5);
    EXPECT_NEAR(s.probability({0, -1e5f, 0}, 1), 0.75, 1e-5);
    EXPECT_NEAR(s.probability({0, 2, 0}, 1), 0.25, 1e-5);
}

// Degenerate sets.

ManyLights pointLights(const std::vector<Vec3f>& positions, const std::function<float(size_t)>& intensity) {
    ManyLights many;
    for (const Vec3f& p : positions)
        many.lights.push_back(makePointLight({p, Rgb(intensity(many.lights.size()))}));
    return many;
}

TEST(LightSelector, HoldsWithLightsAtOnePoint) {
    for (const Vec3f& place : {Vec3f(0.0f), Vec3f(1, 2, 3), Vec3f(1e6f, -1e6f, 1e6f)}) {
        const ManyLights many =
            pointLights(std::vector<Vec3f>(1000, place), [](size_t i) { return 1.0f + i % 7; });
        const LightSelector s = selector(many);
        for (const Vec3f& x : {place, place + Vec3f(1, 0, 0), Vec3f(0, 0, 5)}) {
            EXPECT_NEAR(sumOfProbabilities(s, many.lights.size(), x), 1, 1e-5);
            // Nine tenths by intensity, the rest even.
            EXPECT_NEAR(s.probability(x, 6) / s.probability(x, 0), (0.9 * 7 / 4 + 0.1) / (0.9 / 4 + 0.1),
                        0.01);
        }
        expectSamplesFollow(s, many.lights.size(), place, 20000, 3);
    }
}

TEST(LightSelector, HoldsWithPlacesOfAllScales) {
    // A series that any plane divides unevenly, and a line far from the origin: the tree's depth is bounded.
    std::vector<Vec3f> series, line;
    for (int i = -120; i <= 60; ++i) series.push_back(Vec3f(std::ldexp(1.0f, i), 0, 0));
    for (int i = 0; i < 500; ++i) line.push_back(Vec3f(1e6f, 0.1f * static_cast<float>(i), 0));
    for (const std::vector<Vec3f>& places : {series, line}) {
        const ManyLights many = pointLights(places, [](size_t i) { return i % 2 == 0 ? 1.0f : 1e-20f; });
        const LightSelector s = selector(many);
        for (size_t i = 0; i < places.size(); i += 29) {
            EXPECT_NEAR(sumOfProbabilities(s, many.lights.size(), places[i]), 1, 1e-5);
            expectSamplesFollow(s, many.lights.size(), places[i] + Vec3f(0, 0.3f, 0), 2000, i);
        }
    }
}

TEST(LightSelector, LightsWithoutPowerAreChosenEvenly) {
    const ManyLights many = pointLights({{0, 1, 0}, {0, -1, 0}, {1, 0, 0}}, [](size_t) { return 0.0f; });
    const LightSelector s = selector(many);
    for (uint32_t i = 0; i < 3; ++i) EXPECT_NEAR(s.probability(Vec3f(0.0f), i), 1.0 / 3, 1e-6);
}

TEST(LightSelector, WhereNoLightArrivesItIsByIntensity) {
    // Two spots that look up, seen from below.
    const Transform up = Transform::rotate({1, 0, 0}, -90);
    ManyLights many;
    for (const float intensity : {1.0f, 3.0f})
        many.lights.push_back(makeSpotLight({up, Rgb(intensity), 20, 10, nullptr}));
    const LightSelector s = selector(many);
    EXPECT_NEAR(s.probability({0, -5, 0}, 0), 0.9 * 0.25 + 0.1 * 0.5, 1e-5);
    EXPECT_NEAR(sumOfProbabilities(s, 2, {0, -5, 0}), 1, 1e-6);
}

TEST(LightSelector, NamesALightWithoutFinitePlace) {
    const ManyLights many = pointLights({{0, 0, 0}, {0, INFINITY, 0}}, [](size_t) { return 1.0f; });
    try {
        selector(many);
        FAIL() << "a light at infinity was taken";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("light 2 of 2"), std::string::npos) << error.what();
    }
}

TEST(LightSelector, HoldsWithAHundredThousandLights) {
    const ManyLights many = mixedLights(100000, 9, Vec3f(0.0f), kExtent, 0.01f);
    const LightSelector s = selector(many);
    CounterRng rng(hashKey(4));
    for (int i = 0; i < 3; ++i) {
        const Vec3f x = randomPoint(rng, kExtent);
        EXPECT_NEAR(sumOfProbabilities(s, many.lights.size(), x), 1, 1e-4);
        expectSamplesFollow(s, many.lights.size(), x, 20000, 20 + i);
    }
}

/// A plane of lamps at height 0.6 over a floor, intensities spread over a factor of 100: the relative
/// variance of an estimate of irradiance from one light, all visible, mean over points of the floor.
double varianceOnAFloor(int count) {
    constexpr float kHalf = 60, kHeight = 0.6f;
    CounterRng rng(hashKey(1));
    ManyLights many;
    for (int i = 0; i < count; ++i) {
        const float x = kHalf * (2 * rng.next1D() - 1), z = kHalf * (2 * rng.next1D() - 1);
        const Transform down = Transform::translate({x, kHeight, z}) * Transform::rotate({1, 0, 0}, 90) *
                               Transform::scale(Vec3f(0.02f));
        many.area(makeRectangle(down, false), Rgb(std::pow(100.0f, rng.next1D())));
    }
    const LightSelector s = selector(many);
    double sum = 0;
    constexpr int kPoints = 60;
    for (int i = 0; i < kPoints; ++i) {
        const float px = rng.next1D(), pz = rng.next1D();
        const Vec3f x(10 * px - 5, 0, 10 * pz - 5);
        double first = 0, second = 0;
        for (uint32_t k = 0; k < many.lights.size(); ++k) {
            const LightBounds b = *many.lights[k]->bounds();
            const Vec3f d = (b.lower + b.upper) * 0.5f - x;
            const double irradiance = double(b.intensity) * sqr(double(d.y)) / sqr(double(lengthSquared(d)));
            first += irradiance;
            second += sqr(irradiance) / double(s.probability(x, k));
        }
        sum += second / sqr(first) - 1;
    }
    return sum / kPoints;
}

TEST(LightSelector, PrefersTheLightsThatCount) {
    // Measured with 10,000: 0.5; 2 without the cut; 2600 for a choice half by power, half evenly.
    EXPECT_LT(varianceOnAFloor(100), 1);
    EXPECT_LT(varianceOnAFloor(10000), 1);
}

}  // namespace
}  // namespace metrolux::core
