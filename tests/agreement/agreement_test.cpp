/// Integrators agree. They share the eye subpaths but little else: path finds light by next-event estimation
/// and by chance, bdpt by connections and splats, vcm by merging too, mcmc_vcm samples light subpaths in
/// another way; pssmlt and mmlt those of complete paths, and pssmlt_merge has merging besides.
///
/// Each integrator renders every scene with independent seeds. Means of blocks of the image are compared
/// pairwise by Welch's test with the scatter between seeds, which holds for correlated samples, and Sidak's
/// correction over all blocks, channels, pairs and scenes: all tests together err with probability
/// kFamilyRate.
///
/// Heavy tails. Where an integrator finds a strong path rarely, its block means are skewed: without the rare
/// path both mean and variance are too small, and t has heavier tails than Student's. Nothing is clamped or
/// trimmed, since both hide what is looked for. Instead each mean is over 16 seeds of tens of thousands of
/// samples of many pixels, and a pair is compared only where both integrators can find all the light
/// (Case::integrators says why not). Seeds are fixed: a scene that passes does so again until the code
/// changes.
///
/// Merging blurs over its radius. The radius here is half the default: `vcm` with radii of 1/2 and 1/4 of the
/// default and the same seed differ by less than 1 % of the image mean wherever noise lets it be told (table
/// in docs/conformance.md); bias within a block is what the test would report as a disagreement with path and
/// bdpt.

#include "support/block_statistics.h"
#include "support/scene_rendering.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

namespace metrolux {
namespace {

using namespace test;

constexpr double kFamilyRate = 0.01;
constexpr int kSeeds = 16;
constexpr int kWidth = 64, kHeight = 48, kColumns = 8, kRows = 6;
constexpr double kRadiusFactor = 0.5;

struct Case {
    std::string name, file;
    bool shared = false;
    /// Passes for each seed; absent: the integrator cannot find all the light.
    std::map<std::string, int> integrators;
    int pairs() const { return int(integrators.size() * (integrators.size() - 1) / 2); }
};

const std::map<std::string, int> kAll{{"path", 24}, {"bdpt", 12}, {"vcm", 12}, {"mcmc_vcm", 32}};
/// Where light is not so rare that chains of some thousand steps still depend on a few starts.
const std::map<std::string, int> kAllAndPathChains{{"path", 24},        {"bdpt", 12},   {"vcm", 12},
                                                   {"mcmc_vcm", 32},    {"pssmlt", 16}, {"mmlt", 16},
                                                   {"pssmlt_merge", 16}};
/// Light that reaches the camera over specular, diffuse, specular vertices from a light of no size.
const std::map<std::string, int> kMergingOnly{{"vcm", 24}, {"mcmc_vcm", 48}};

const std::vector<Case> kCases{
    {"door_ajar", "door-ajar/scene.xml", false, kAll},
    {"environment", "environment/scene.xml", false, kAllAndPathChains},
    {"glass_sphere", "glass-sphere/scene.xml", false, kMergingOnly},
    {"glossy_room", "glossy-room/scene.xml", false, kAllAndPathChains},
    {"mis", "mis/scene.xml", false, kAll},
    {"spot_directional", "spot-directional/scene.xml", false, kMergingOnly},
    {"textured", "textured/scene.xml", false, kAllAndPathChains},
    {"water_sds", "water-sds/scene.xml", false, kMergingOnly},
    {"cornell_box", "cornell-box/scene.xml", true, kAllAndPathChains},
    {"veach_mis", "veach-mis/scene.xml", true, kAll},
    {"veach_bidir", "veach-bidir/scene.xml", true, kAll},
    {"veach_ajar", "veach-ajar/scene.xml", true, kAll},
    {"water_caustic", "water-caustic/scene.xml", true, kMergingOnly},
    {"torus", "torus/scene.xml", true, kMergingOnly},
    {"cbox_rgb", "cbox/cbox-rgb.xml", true, kAll},
    {"cbox", "cbox/cbox.xml", true, kAll},
    {"matpreview", "matpreview/matpreview.xml", true, kAllAndPathChains},
};

double level() {
    double tests = 0;
    for (const Case& c : kCases) tests += c.pairs() * kColumns * kRows * 3.0;
    return sidak(kFamilyRate, tests);
}

void PrintTo(const Case& c, std::ostream* out) { *out << c.file; }

class Agreement : public testing::TestWithParam<Case> {};

TEST_P(Agreement, OfAllPairs) {
    const Case& c = GetParam();
    const std::filesystem::path root = c.shared ? METROLUX_SHARED_DIR : METROLUX_SOURCE_DIR;
    const std::filesystem::path file = root / "scenes" / c.file;
    if (c.shared && !std::filesystem::exists(file))
        GTEST_SKIP() << file.string() << " is absent: the integrators were not compared in it";

    const CpuTimer timer;
    LoadOptions options;
    options.width = kWidth;
    options.height = kHeight;
    const RenderableScene scene(file, options);
    std::map<std::string, BlockStatistics> blocks;
    for (const auto& [integrator, passes] : c.integrators) {
        BlockStatistics& b = blocks.try_emplace(integrator, kWidth, kHeight, kColumns, kRows).first->second;
        for (const auto& image : scene.renderSeeds(integrator, passes, 1000, kSeeds, kRadiusFactor))
            b.add(image);
    }

    for (auto a = blocks.begin(); a != blocks.end(); ++a)
        for (auto b = std::next(a); b != blocks.end(); ++b) {
            double least = 1;
            std::string worst;
            std::vector<double> detectable;
            for (size_t i = 0; i < a->second.size(); ++i) {
                const double meanA = a->second.mean(i), meanB = b->second.mean(i);
                const WelchResult r = welch(meanA, a->second.varianceOfMean(i), a->second.degreesOfFreedom(),
                                            meanB, b->second.varianceOfMean(i), b->second.degreesOfFreedom());
                if (meanA + meanB > 0) detectable.push_back(2 * r.halfWidth(level()) / (meanA + meanB));
                if (r.pValue >= least) continue;
                least = r.pValue;
                worst = fmt::format("block ({}, {}) {}: {:.5f} and {:.5f}, t = {:.1f}, p = {:.1g}",
                                    i / 3 % kColumns, i / 3 / kColumns, "RGB"[i % 3], meanA, meanB,
                                    r.difference / r.standardError, r.pValue);
            }
            ASSERT_FALSE(detectable.empty());
            std::sort(detectable.begin(), detectable.end());
            fmt::print("| {} | {} - {} | {:+.2f} % | {:.1g} | {:.1f} % |\n", c.name, a->first, b->first,
                       100 * (a->second.total() / b->second.total() - 1), least,
                       100 * detectable[detectable.size() / 2]);
            EXPECT_GT(least, level()) << a->first << " and " << b->first << " disagree: " << worst;
        }
    fmt::print("{}: {:.0f} s of processor time\n", c.name, timer.seconds());
}

INSTANTIATE_TEST_SUITE_P(Scenes, Agreement, testing::ValuesIn(kCases),
                         [](const auto& parameter) { return parameter.param.name; });

}  // namespace
}  // namespace metrolux
