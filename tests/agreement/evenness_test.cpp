/// "The resulting algorithm often suffered from non-uniform convergence" (supplement, 4.2.1, of split_mcmc):
/// errors of the parts of an image against those of vcm after the same number of passes.

#include "paths.h"
#include "support/block_statistics.h"
#include "support/scene_rendering.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using namespace test;

constexpr int kSeeds = 12, kPasses = 8;
constexpr int kWidth = 64, kHeight = 48, kColumns = 8, kRows = 6;

/// For each block and channel, the variance of its pixels over seeds (their mean, not that of the block's
/// mean).
std::vector<double> pixelVariances(const RenderableScene& scene, const std::string& integrator,
                                   uint64_t firstSeed, const BlockStatistics& blocks) {
    const auto images = scene.renderSeeds(integrator, kPasses, firstSeed, kSeeds, 1);
    std::vector<float> variance(images[0].size());
    for (size_t i = 0; i < variance.size(); ++i) {
        double sum = 0, squares = 0;
        for (const auto& image : images) {
            sum += image[i];
            squares += double(image[i]) * image[i];
        }
        variance[i] = static_cast<float>((squares - sum * sum / kSeeds) / (kSeeds - 1));
    }
    return blocks.blockMeans(variance);
}

double quantile(std::vector<double> sorted, double q) {
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<size_t>(q * double(sorted.size() - 1))];
}

/// Ratios of the variances of two integrators over the blocks (green).
struct Spread {
    double low, median, high;  ///< a tenth of the blocks lies below, half of them, a tenth above
    double range() const { return high / low; }
};
Spread spreadOf(const std::vector<double>& variances, const std::vector<double>& reference) {
    std::vector<double> ratios;
    for (size_t i = 1; i < reference.size(); i += 3)
        if (reference[i] > 0) ratios.push_back(variances[i] / reference[i]);
    return {quantile(ratios, 0.1), quantile(ratios, 0.5), quantile(ratios, 0.9)};
}

class Evenness : public testing::TestWithParam<const char*> {};

TEST_P(Evenness, SplitMcmcConvergesWorseInSomePartsThanInOthers) {
    LoadOptions options;
    options.width = kWidth;
    options.height = kHeight;
    const std::string name = GetParam();
    const RenderableScene scene(std::filesystem::path(METROLUX_SOURCE_DIR) / "scenes" / name / "scene.xml",
                                options);
    const BlockStatistics blocks(kWidth, kHeight, kColumns, kRows);
    const std::vector<double> vcm = pixelVariances(scene, "vcm", 1, blocks);
    // An integrator that is merely slower has the same ratio everywhere, up to the noise of variances: as vcm
    // itself with other seeds.
    const Spread split = spreadOf(pixelVariances(scene, "split_mcmc", 1, blocks), vcm),
                 control = spreadOf(pixelVariances(scene, "vcm", 101, blocks), vcm);
    for (const auto& [what, s] : {std::pair("split_mcmc", split), std::pair("vcm, other seeds", control)})
        fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.1f} |\n", name, what, s.low, s.median, s.high,
                   s.range());
    EXPECT_GT(split.range(), 1.2 * control.range());
}

INSTANTIATE_TEST_SUITE_P(Scenes, Evenness, testing::Values("water-sds", "glossy-room"), [](const auto& i) {
    std::string name = i.param;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
});

}  // namespace
}  // namespace metrolux::core
