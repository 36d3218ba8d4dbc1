#include "base/error.h"
#include "integrators/iteration.h"
#include "integrators/registry.h"
#include "support/small_scenes.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include <array>
#include <numeric>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

std::vector<float> render(const Scene& scene, const std::string& name, CommonOptions options, int passes,
                          int threads = 2,
                          ReconstructionFilter::Kind filter = ReconstructionFilter::Kind::Tent) {
    options.limits = scene.parts().limits;
    Film film(scene.camera().window(), ReconstructionFilter(filter, {}));
    const std::unique_ptr<Integrator> integrator = makeIntegrator(name, scene, options);
    tbb::task_arena arena(threads);
    arena.execute([&] {
        for (int i = 0; i < passes; ++i) integrator->renderPass(film, film.passes());
    });
    EXPECT_EQ(film.passes(), uint32_t(passes));
    EXPECT_EQ(integrator->nonFinite(), TechniqueCounts{}) << name;
    EXPECT_TRUE(integrator->statistics().is_object());
    return film.image();
}

class EachIntegrator : public ::testing::TestWithParam<std::string> {};

void addFloorAndGlass(SceneBuilder& b) {
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), makeDielectric({}));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 24, 20);
}

TEST_P(EachIntegrator, WithoutLightsTheImageIsBlack) {
    SceneBuilder b;
    addFloorAndGlass(b);
    for (const float v : render(*b.build(), GetParam(), {}, 3)) ASSERT_EQ(v, 0);
}

TEST_P(EachIntegrator, WithoutSurfacesOnlyTheEnvironmentIsSeen) {
    SceneBuilder dark;
    PointLightParameters p;
    dark.light(makePointLight(p));
    dark.camera({0, 0, 5}, {0, 0, 0}, 50, 12, 10);
    for (const float v : render(*dark.build(), GetParam(), {}, 2)) ASSERT_EQ(v, 0);

    SceneBuilder sky;
    sky.light(makeConstantLight({Rgb(2.0f)}));
    sky.camera({0, 0, 5}, {0, 0, 0}, 50, 12, 10);
    for (const float v : render(*sky.build(), GetParam(), {}, 2)) ASSERT_NEAR(v, 2, 1e-5f);
}

TEST_P(EachIntegrator, LightsWithoutPowerGiveBlack) {
    SceneBuilder b;
    addFloorAndGlass(b);
    PointLightParameters p;
    p.position = {0, 3, 0};
    p.intensity = Rgb(0.0f);
    b.light(makePointLight(p));
    for (const float v : render(*b.build(), GetParam(), {}, 3)) ASSERT_EQ(v, 0);
}

TEST_P(EachIntegrator, GivesTheSameBitsOnOneAndTwoThreadsAndOthersForAnotherSeed) {
    SceneBuilder b;
    addFloorAndGlass(b);
    b.emit(b.add(test::rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)), Rgb(5));
    const std::shared_ptr<Scene> scene = b.build();
    CommonOptions options;
    options.seed = 5;
    const std::vector<float> one = render(*scene, GetParam(), options, 4, 1);
    EXPECT_EQ(one, render(*scene, GetParam(), options, 4, 2));
    options.seed = 6;
    EXPECT_NE(one, render(*scene, GetParam(), options, 4, 1));
}

TEST_P(EachIntegrator, HidesDirectlyVisibleEmittersWhenAsked) {
    SceneBuilder b;
    b.light(makeConstantLight({}));
    b.emit(b.add(test::rectangle({0, 0, 0}, {0, 0, 1}, 1, 1), test::diffuse(0.0f)), Rgb(5));
    b.camera({0, 0, 5}, {0, 0, 0}, 50, 12, 10);
    b.limits().hideEmitters = true;
    for (const float v : render(*b.build(), GetParam(), {}, 3)) ASSERT_EQ(v, 0);
}

/// Mean and squared standard error of the image's mean, over renderings with the filter.
std::array<double, 2> brightness(const Scene& scene, const std::string& name,
                                 ReconstructionFilter::Kind filter) {
    constexpr int kSeeds = 8, kPasses = 12;
    std::vector<double> means;
    for (int seed = 0; seed < kSeeds; ++seed) {
        CommonOptions options;
        options.seed = static_cast<uint64_t>(seed);
        const std::vector<float> image = render(scene, name, options, kPasses, 2, filter);
        means.push_back(std::accumulate(image.begin(), image.end(), 0.0) / double(image.size()));
    }
    const double mean = std::accumulate(means.begin(), means.end(), 0.0) / kSeeds;
    double squares = 0;
    for (const double m : means) squares += (m - mean) * (m - mean);
    return {mean, squares / (kSeeds * (kSeeds - 1))};
}

/// Where such a filter is negative, so is what an eye subpath contributes, and with it most of what a light
/// subpath can add to it. Chains whose target was the signed sum ended with an error or left it out.
TEST_P(EachIntegrator, FiltersWithNegativeLobesKeepTheBrightness) {
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), test::diffuse(0.5f));
    b.emit(b.add(test::rectangle({1.5f, 4, 1}, {0, -1, 0}, 0.5f, 0.5f), test::diffuse(0.0f)), Rgb(20));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 24, 20);
    const std::shared_ptr<Scene> scene = b.build();
    const auto filter = ReconstructionFilter::Kind::CatmullRom;
    const auto [mean, variance] = brightness(*scene, GetParam(), filter);
    const auto [expected, itsVariance] = brightness(*scene, "path", filter);
    // 6 standard errors of 8 seeds, and what merging blurs over the edges of the image.
    EXPECT_NEAR(mean, expected, 6 * std::sqrt(variance + itsVariance) + 0.005 * expected);
}

std::vector<std::string> names() {
    std::vector<std::string> result;
    for (const IntegratorDescription& integrator : integratorList()) result.push_back(integrator.name);
    return result;
}
INSTANTIATE_TEST_SUITE_P(All, EachIntegrator, ::testing::ValuesIn(names()),
                         [](const auto& i) { return i.param; });

TEST(RadiusSchedule, FollowsTheProductForm) {
    // prod (i + alpha) / (i + 1): alpha = 1 keeps the radius, 3/4 shrinks r^2 as i^(alpha - 1) in the long
    // run.
    RadiusSchedule constant(2, 1), shrinking(2, 0.75);
    double squared = 4;
    for (int i = 1; i <= 1000; ++i) {
        constant.advance();
        shrinking.advance();
        squared *= (i + 0.75) / (i + 1);
        ASSERT_NEAR(shrinking.radius(), std::sqrt(squared), 1e-9);
    }
    EXPECT_DOUBLE_EQ(constant.radius(), 2);
    EXPECT_NEAR(shrinking.radius() * shrinking.radius() / (4 * std::pow(1000.0, -0.25) / std::tgamma(1.75)),
                1, 1e-2);
}

TEST(PixelPartition, CoversEveryPixelOnceWithinTheBound) {
    FilmWindow window;
    window.fullWidth = window.width = 57;
    window.fullHeight = window.height = 31;
    CommonOptions options;
    EXPECT_EQ(PixelPartition(window, options).parts(), 1);
    for (const size_t bytes : {size_t(1), size_t(100000), size_t(20000000)}) {
        options.memoryBytes = bytes;
        const PixelPartition partition(window, options);
        std::vector<int> seen(window.pixelCount());
        for (int part = 0; part < partition.parts(); ++part)
            for (const uint32_t pixel : partition.pixels(part)) ++seen[pixel];
        for (const int s : seen) ASSERT_EQ(s, 1);
        EXPECT_EQ(partition.parts() > 1, bytes < 20000000);
    }
}

TEST(ProjectedPixelRadius, IsThePixelsWidthOnWhatTheCameraSees) {
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 0, 1}, 10, 10), test::diffuse(0.5f));
    b.camera({0, 0, 5}, {0, 0, 0}, 20, 100, 100);
    const double pixel = 2 * 5 * std::tan(radians(10)) / 100;
    const std::shared_ptr<Scene> scene = b.build();
    EXPECT_NEAR(projectedPixelRadius(*scene, {}) / pixel, 1, 0.1);
    MergingParameters open, chosen{0.25};
    open.resolve(*scene, {});
    chosen.resolve(*scene, {});
    EXPECT_EQ(open.radius, projectedPixelRadius(*scene, {}));
    EXPECT_EQ(chosen.radius, 0.25);
    SceneBuilder nothing;
    nothing.camera({0, 0, 5}, {0, 0, 0}, 20, 100, 100);
    EXPECT_GT(projectedPixelRadius(*nothing.build(), {}), 0);
}

}  // namespace
}  // namespace metrolux::core
