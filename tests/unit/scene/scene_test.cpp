#include "scene/scene.h"

#include "base/error.h"
#include "base/rng.h"
#include "support/goodness_of_fit.h"
#include "support/small_scenes.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

LightPtr pointLight(const Vec3f& position, float intensity) {
    PointLightParameters p;
    p.position = position;
    p.intensity = Rgb(intensity);
    return makePointLight(p);
}

TEST(Scene, VisibilityHoldsAtAnyCoordinates) {
    // A room with a wall; offset by up to 1e6, sized to what single precision can still tell apart there.
    for (const float offset : {0.0f, 1e3f, 1e5f, 1e6f})
        for (const float size : {1.0f, 100.0f}) {
            if (size < offset * 1e-5f) continue;
            const Vec3f o(offset, -offset, 0.7f * offset);
            SceneBuilder b;
            b.add(test::rectangle(o, {0, 1, 0}, 4 * size, 4 * size), test::diffuse(0.5f));
            b.add(test::rectangle(o + Vec3f(0, size, 0), {0, 1, 0}, size, size), test::diffuse(0.5f));
            b.camera(o + Vec3f(0, size, 5 * size), o, 50, 8, 8);
            const std::shared_ptr<Scene> scene = b.build();
            const Vec3f up(0, 1, 0), none(0.0f);
            CounterRng rng(1);
            for (int i = 0; i < 300; ++i) {
                const Vec3f floor =
                    o + Vec3f(3 * (2 * rng.next1D() - 1), 0, 3 * (2 * rng.next1D() - 1)) * size;
                const Vec3f above = o + Vec3f(2 * rng.next1D() - 1, 2, 2 * rng.next1D() - 1) * size;
                const Vec3f half = (floor + above) * 0.5f - o;
                // offsetRayOrigin moves the start by 4e-6 of the coordinate; slanting rays magnify that.
                const float margin = 1e-3f * size + 2e-5f * offset;
                if (std::abs(std::abs(half.x) - size) < margin || std::abs(std::abs(half.z) - size) < margin)
                    continue;
                const bool free = std::abs(half.x) > size || std::abs(half.z) > size;
                ASSERT_EQ(scene->visible(floor, up, above, none), free) << offset << " " << i;
                ASSERT_EQ(scene->visible(above, none, floor, up), free) << offset << " " << i;
                const Vec3f w = normalize(above - floor);
                ASSERT_EQ(scene->visibleToInfinity(floor, up, w), free) << offset << " " << i;
                // The normal only says on which side the ray starts: downwards there is nothing.
                ASSERT_TRUE(scene->visibleToInfinity(floor, up, w * Vec3f(1, -1, 1)));
            }
        }
}

TEST(Scene, PointsOfOneSurfaceSeeEachOther) {
    // No self-shadowing along a shared plane, nor between points that are very near.
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 10, 10), test::diffuse(0.5f));
    b.camera({0, 1, 5}, {0, 0, 0}, 50, 8, 8);
    const std::shared_ptr<Scene> scene = b.build();
    for (const float distance : {1e-4f, 1e-2f, 1.0f, 5.0f})
        EXPECT_TRUE(scene->visible({distance, distance, 0}, {0, 0, 0}, {0, 0, 0}, {0, 1, 0}));
    EXPECT_TRUE(scene->visible({1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}));
}

TEST(Scene, LightSelectionIsADistributionAndSamplesFollowIt) {
    SceneBuilder b;
    for (const float intensity : {1.0f, 100.0f, 0.0f, 7.0f})
        b.light(pointLight({intensity, 2, 0}, intensity));
    b.emit(b.add(test::rectangle({0, 3, 0}, {0, -1, 0}, 1, 1), test::diffuse(0.5f)), Rgb(3));
    b.light(makeConstantLight({}));
    b.camera({0, 1, 5}, {0, 0, 0}, 50, 8, 8);
    const std::shared_ptr<Scene> scene = b.build();
    const size_t n = scene->lights().size();
    ASSERT_EQ(n, 6u);

    const Vec3f x(0.3f, 0, 0.2f);
    for (const bool emission : {false, true}) {
        double sum = 0;
        std::vector<double> observed(n), expected(n);
        constexpr int kSamples = 100000;
        for (size_t i = 0; i < n; ++i) {
            const Light* light = scene->lights()[i].get();
            const double p =
                emission ? scene->emissionProbability(light) : scene->connectionProbability(x, light);
            EXPECT_GT(p, 0) << "every light has a defensive share";
            sum += p;
            expected[i] = p * kSamples;
        }
        EXPECT_NEAR(sum, 1, 1e-6);
        CounterRng rng(5);
        for (int k = 0; k < kSamples; ++k) {
            float u = rng.next1D();
            const Scene::LightChoice c =
                emission ? scene->chooseLightForEmission(u) : scene->chooseLightForConnection(x, u);
            ASSERT_TRUE(u >= 0 && u < 1);
            size_t i = 0;
            while (scene->lights()[i].get() != c.light) ++i;
            ASSERT_FLOAT_EQ(c.probability, float(expected[i] / kSamples));
            observed[i] += 1;
        }
        EXPECT_GT(test::chiSquarePValue(observed, expected), test::kLevel);
    }
    // Power decides emission: the point light of intensity 100 before that of 1.
    EXPECT_GT(scene->emissionProbability(scene->lights()[1].get()),
              3 * scene->emissionProbability(scene->lights()[0].get()));
}

TEST(Scene, LightsWithoutPowerAreChosenEvenly) {
    SceneBuilder b;
    b.light(pointLight({0, 1, 0}, 0));
    b.light(pointLight({0, -1, 0}, 0));
    b.camera({0, 1, 5}, {0, 0, 0}, 50, 8, 8);
    const std::shared_ptr<Scene> scene = b.build();
    EXPECT_FLOAT_EQ(scene->emissionProbability(scene->lights()[0].get()), 0.5f);
    EXPECT_FLOAT_EQ(scene->connectionProbability({0, 0, 0}, scene->lights()[1].get()), 0.5f);
}

TEST(Scene, WithoutLightsNothingIsChosen) {
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 1, 1), test::diffuse(0.5f));
    b.camera({0, 1, 5}, {0, 0, 0}, 50, 8, 8);
    const std::shared_ptr<Scene> scene = b.build();
    float u = 0.5f;
    EXPECT_EQ(scene->chooseLightForEmission(u).light, nullptr);
    EXPECT_EQ(scene->chooseLightForConnection({0, 0, 0}, u).light, nullptr);
    EXPECT_EQ(scene->environment(), nullptr);
}

TEST(Scene, KnowsItsEnvironmentAndTakesOnlyOne) {
    SceneBuilder b;
    b.light(pointLight({0, 1, 0}, 1));
    const LightPtr environment = makeConstantLight({});
    b.light(environment);
    b.camera({0, 1, 5}, {0, 0, 0}, 50, 8, 8);
    EXPECT_EQ(b.build()->environment(), environment.get());

    SceneBuilder two;
    two.light(makeConstantLight({}));
    two.light(makeConstantLight({}));
    two.camera({0, 1, 5}, {0, 0, 0}, 50, 8, 8);
    EXPECT_THROW(two.build(), Error);
    SceneBuilder none;
    none.light(makeConstantLight({}));
    EXPECT_THROW(none.build(), Error);  // no camera
}

TEST(Scene, BoundsHoldSurfacesAndTheCamera) {
    SceneBuilder b;
    b.add(makeSphere(Transform(), {10, 0, 0}, 2, false), test::diffuse(0.5f));
    b.camera({-5, 1, 5}, {0, 0, 0}, 50, 8, 8);
    const std::shared_ptr<Scene> scene = b.build();
    const SceneBounds& s = scene->bounds();
    for (const Vec3f& p : {Vec3f(12, 0, 0), Vec3f(10, 2, 0), Vec3f(10, 0, -2), Vec3f(-5, 1, 5)})
        EXPECT_LE((p - s.center).length(), s.radius);

    SceneBuilder empty;
    empty.light(makeConstantLight({}));
    empty.camera({3, 4, 5}, {0, 0, 0}, 50, 8, 8);
    const std::shared_ptr<Scene> nothing = empty.build();
    EXPECT_GT(nothing->bounds().radius, 0);
    EXPECT_LE((nothing->bounds().center - Vec3f(3, 4, 5)).length(), nothing->bounds().radius);
    EXPECT_TRUE(nothing->visible({0, 0, 0}, Vec3f(0.0f), {1, 1, 1}, Vec3f(0.0f)));
}

}  // namespace
}  // namespace metrolux::core
