/// Integrators agree: path, bdpt, vcm and mcmc_vcm with each other, all others with vcm. They share the eye
/// subpaths but little else: path finds light by next-event estimation and by chance, bdpt by connections and
/// splats, vcm by merging too, mcmc_vcm samples light subpaths in another way, split_mcmc eye subpaths too;
/// pssmlt and mmlt those of complete paths, and pssmlt_merge has merging besides; sppm and vpt do all by
/// merging.
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
/// (Case::without says why not). Seeds are fixed: a scene that passes does so again until the code
/// changes.
///
/// Merging blurs over its radius. The radius here is half the default: `vcm` with radii of 1/2 and 1/4 of the
/// default and the same seed differ by less than 1 % of the image mean wherever noise lets it be told (table
/// in docs/lab/conformance.md); bias within a block is what the test would report as a disagreement with path
/// and bdpt. Photon mapping (sppm, vpt), which makes all light by merging, is darker than vcm by 1.0 % +- 0.2
/// % of the mean of cornell_box with the default radius and by 0.5 % +- 0.3 % with half of it, which a
/// block's test does not tell (docs/lab/integrators.md).

#include "paths.h"
#include "support/block_statistics.h"
#include "support/scene_rendering.h"
#include "support/shared_data.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

namespace metrolux::core {
namespace {

using namespace test;

constexpr double kFamilyRate = 0.01;
constexpr int kSeeds = 16;
constexpr int kWidth = 64, kHeight = 48, kColumns = 8, kRows = 6;
constexpr double kRadiusFactor = 0.5;

/// How an integrator is run in a scene.
struct Run {
    int passes = 0;  ///< for each seed
    std::string integrator;
    double radiusFactor = kRadiusFactor;
    ParameterValues parameters = {};
};
/// By name; an integrator that is absent cannot find all the light, or not decide in reasonable time.
using Runs = std::map<std::string, Run>;

struct Case {
    std::string name, file;
    bool shared = false;
    Runs runs;
    std::string without = {};  ///< which integrators are absent, and why
};

Run run(const std::string& integrator, int passes) { return {passes, integrator}; }

Runs together(Runs a, const Runs& b) {
    a.insert(b.begin(), b.end());
    return a;
}

/// The core, of which all pairs are compared; the others are compared with vcm alone, which every scene has.
const Runs kCore{{"path", run("path", 24)},
                 {"bdpt", run("bdpt", 12)},
                 {"vcm", run("vcm", 12)},
                 {"mcmc_vcm", run("mcmc_vcm", 32)}};
bool isCore(const std::string& name) { return kCore.contains(name); }
bool compared(const std::string& a, const std::string& b) {
    return a == "vcm" || b == "vcm" || (isCore(a) && isCore(b));
}
const Runs kSplit{{"split_mcmc", run("split_mcmc", 8)}};
const Runs kPhotonMapping{{"sppm", run("sppm", 16)}, {"vpt", run("vpt", 16)}};
/// Where light is not so rare that chains of some thousand steps still depend on a few starts.
const Runs kPathChains{
    {"pssmlt", run("pssmlt", 16)}, {"mmlt", run("mmlt", 16)}, {"pssmlt_merge", run("pssmlt_merge", 16)}};
const Runs kAdaptive{{"pssmlt, adaptive", {16, "pssmlt", kRadiusFactor, {{"kernel", "adaptive"}}}}};

/// With small steps, chains that are not left to themselves show it best.
const Runs kSplitKelemen{{"split_mcmc, kelemen", {12, "split_mcmc", kRadiusFactor, {{"kernel", "kelemen"}}}}};

/// Chains all the way, in scenes that are so easy that mcmc_vcm does without them.
const Runs kChains{{"mcmc_vcm, fixed", {32, "mcmc_vcm", kRadiusFactor, {{"fixed", true}}}}};

const Runs kConnections{{"path", run("path", 32)}, {"bdpt", run("bdpt", 16)}, {"vcm", run("vcm", 16)}};

const Runs kSplitAlone = together(kCore, kSplit);
const Runs kWithPhotons = together(kSplitAlone, kPhotonMapping);
const Runs kWithPathChains = together(together(kSplitAlone, kPathChains), kAdaptive);
const Runs kEverything = together(kWithPhotons, together(kPathChains, kAdaptive));
/// Light that reaches the camera over specular, diffuse, specular vertices from a light of no size.
const Runs kMergingOnly{{"vcm", run("vcm", 24)},
                        {"mcmc_vcm", run("mcmc_vcm", 48)},
                        {"sppm", run("sppm", 24)},
                        {"vpt", run("vpt", 24)},
                        {"split_mcmc", run("split_mcmc", 16)},
                        {"pssmlt_merge", run("pssmlt_merge", 16)}};

/// In media, where photon mapping darkens and path chains are long.
const Runs kInMedia = together(kCore, kSplit);
const Runs kInHaze{{"bdpt", run("bdpt", 16)},
                   {"vcm", run("vcm", 16)},
                   {"mcmc_vcm", run("mcmc_vcm", 32)},
                   {"split_mcmc", run("split_mcmc", 12)}};
const Runs kInWater{{"vcm", run("vcm", 32)}, {"mcmc_vcm", run("mcmc_vcm", 64)}};

const char* const kRare = "path chains: light so rare that some thousand steps depend on a few starts";
const char* const kAjar =
    "path chains, sppm, vpt: light so rare that 16 short renders do not tell their own error";
const char* const kGlossy =
    "sppm, vpt: narrow lobes that hardly any photon falls into; block means without the "
    "rare one are too dark with too small an error";
const char* const kDirectLight = "the others: the scene is for the choice of lights by next-event estimation";
const char* const kSameAsCbox = "the others: the same room in other colors as cbox";
const char* const kLikeCornellBox = "path chains: cornell_box is alike";
const char* const kLikePanorama = "the others: panorama is alike";
const char* const kMergingNeeded =
    "path, bdpt, pssmlt, mmlt: find no light or hardly any through specular, "
    "diffuse, specular vertices";

const char* const kMedia =
    "sppm, vpt: merging in media darkens (docs/explain/media.md); path chains: many bounces";
const char* const kHaze =
    "path: cannot find the caustic of a light of no size; sppm, vpt: merging in media darkens";

const char* const kSlit =
    "path: cannot find the light of a lamp of no size behind glass; sppm, vpt: blur a thin beam; path chains: "
    "light so rare that some thousand steps depend on a few starts";

const std::vector<Case> kCases{
    {"cloud", "cloud/scene.xml", false, kInMedia, kMedia},
    {"door_ajar", "door-ajar/scene.xml", false, kSplitAlone, kAjar},
    {"environment", "environment/scene.xml", false, kEverything},
    {"glass_sphere", "glass-sphere/scene.xml", false, kMergingOnly, kMergingNeeded},
    {"glossy_room", "glossy-room/scene.xml", false, together(kWithPathChains, kChains), kGlossy},
    {"haze", "haze/scene.xml", false, kInHaze, kHaze},
    {"mis", "mis/scene.xml", false, together(kSplitAlone, kChains), kGlossy},
    {"murky_pool", "murky-pool/scene.xml", false, kInWater, kMergingNeeded},
    {"prism", "prism/scene.xml", false, kInHaze, kSlit},
    {"spot_directional", "spot-directional/scene.xml", false, kMergingOnly, kMergingNeeded},
    {"textured", "textured/scene.xml", false, together(kWithPathChains, kChains), kGlossy},
    {"tinted_glass", "tinted-glass/scene.xml", false, kMergingOnly, kMergingNeeded},
    {"water_sds", "water-sds/scene.xml", false, kMergingOnly, kMergingNeeded},
    {"wax", "wax/scene.xml", false, kInMedia, kMedia},
    {"lamps", "../tests/agreement/lamps.xml", false, kConnections, kDirectLight},
    {"panorama", "../tests/agreement/panorama.xml", false, kEverything},
    {"fisheye", "../tests/agreement/fisheye.xml", false, kCore, kLikePanorama},
    {"cornell_box", "cornell-box/scene.xml", true, together(kEverything, kChains)},
    {"veach_mis", "veach-mis/scene.xml", true, kSplitAlone, kGlossy},
    {"veach_bidir", "veach-bidir/scene.xml", true, kWithPhotons, kRare},
    {"veach_ajar", "veach-ajar/scene.xml", true, kSplitAlone, kAjar},
    {"water_caustic", "water-caustic/scene.xml", true, kMergingOnly, kMergingNeeded},
    {"torus", "torus/scene.xml", true, kMergingOnly, kMergingNeeded},
    {"cbox_rgb", "cbox/cbox-rgb.xml", true, kCore, kSameAsCbox},
    {"cbox", "cbox/cbox.xml", true, together(kWithPhotons, kSplitKelemen), kLikeCornellBox},
    {"matpreview", "matpreview/matpreview.xml", true, kWithPathChains, kGlossy},
};

double level() {
    double tests = 0;
    for (const Case& c : kCases)
        for (auto a = c.runs.begin(); a != c.runs.end(); ++a)
            for (auto b = std::next(a); b != c.runs.end(); ++b)
                if (compared(a->first, b->first)) tests += kColumns * kRows * 3.0;
    return sidak(kFamilyRate, tests);
}

void PrintTo(const Case& c, std::ostream* out) { *out << c.file; }

class Agreement : public testing::TestWithParam<Case> {};

TEST_P(Agreement, OfPairs) {
    const Case& c = GetParam();
    const std::filesystem::path scenes =
        c.shared ? sharedPath("scenes") : std::filesystem::path(METROLUX_SOURCE_DIR) / "scenes";
    const std::filesystem::path file = scenes / c.file;
    if (c.shared) METROLUX_NEEDS_SHARED(file);

    const CpuTimer timer;
    LoadOptions options;
    options.width = kWidth;
    options.height = kHeight;
    const RenderableScene scene(file, options);
    std::map<std::string, BlockStatistics> blocks;
    for (const auto& [name, r] : c.runs) {
        BlockStatistics& b = blocks.try_emplace(name, kWidth, kHeight, kColumns, kRows).first->second;
        for (const auto& image :
             scene.renderSeeds(r.integrator, r.passes, 1000, kSeeds, r.radiusFactor, r.parameters))
            b.add(image);
    }

    for (auto a = blocks.begin(); a != blocks.end(); ++a)
        for (auto b = std::next(a); b != blocks.end(); ++b) {
            if (!compared(a->first, b->first)) continue;
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
    if (!c.without.empty()) fmt::print("{}: without {}\n", c.name, c.without);
    fmt::print("{}: {:.0f} s of processor time\n", c.name, timer.seconds());
}

INSTANTIATE_TEST_SUITE_P(Scenes, Agreement, testing::ValuesIn(kCases),
                         [](const auto& parameter) { return parameter.param.name; });

}  // namespace
}  // namespace metrolux::core
