/// "The resulting algorithm often suffered from non-uniform convergence" (supplement, 4.2.1, of split_mcmc):
/// where the errors of an integrator are distributed over the image as those of vcm are, and where not.
///
/// The ratio of the two integrators' variances is taken block by block, from two halves of the seeds. An
/// integrator that is as uneven as vcm, though slower, has the same ratio everywhere: a block that lies above
/// the median in one half does so in the other with probability 1/2, however noisy its variances are. (The
/// range of the ratios of one half cannot tell: it is mostly noise.)

#include "paths.h"
#include "support/block_statistics.h"
#include "support/scene_rendering.h"

#include <boost/math/distributions/hypergeometric.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>

namespace metrolux::core {
namespace {

using namespace test;

constexpr int kSeeds = 16;  // of each half
constexpr int kPasses = 8;
constexpr int kWidth = 64, kHeight = 48, kColumns = 8, kRows = 6;

/// For each block, the variance of its pixels over seeds (their mean, not that of the block's mean); green.
std::vector<double> pixelVariances(const RenderableScene& scene, const std::string& integrator,
                                   uint64_t firstSeed) {
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
    const std::vector<double> all = BlockStatistics(kWidth, kHeight, kColumns, kRows).blockMeans(variance);
    std::vector<double> green;
    for (size_t i = 1; i < all.size(); i += 3) green.push_back(all[i]);
    return green;
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Blocks that lie on the same side of the median ratio in both halves of the seeds.
struct Agreement {
    int blocks = 0, same = 0;
    double low = 0, high = 0;  ///< median of the ratio over blocks that lie below and above in both halves
    /// Probability of as many or more when the halves know nothing of each other. In each, half of the blocks
    /// lie above: how many lie above in both has a hypergeometric distribution, and so has `same`, twice
    /// that.
    double pValue() const {
        const auto n = static_cast<unsigned>(blocks), above = (n + 1) / 2;
        const boost::math::hypergeometric_distribution<double> chance(above, above, n);
        const unsigned both = (static_cast<unsigned>(same) + 2 * above - n) / 2;
        return both > 0 ? boost::math::cdf(boost::math::complement(chance, both - 1)) : 1;
    }
};

Agreement agreement(const std::array<std::vector<double>, 2>& variances,
                    const std::array<std::vector<double>, 2>& reference) {
    std::array<std::vector<double>, 2> ratios;
    for (size_t block = 0; block < reference[0].size(); ++block) {
        if (!(reference[0][block] > 0) || !(reference[1][block] > 0)) continue;  // black
        for (size_t half = 0; half < 2; ++half)
            ratios[half].push_back(variances[half][block] / reference[half][block]);
    }
    const double middle0 = median(ratios[0]), middle1 = median(ratios[1]);
    Agreement result;
    result.blocks = static_cast<int>(ratios[0].size());
    std::vector<double> low, high;
    for (size_t i = 0; i < ratios[0].size(); ++i) {
        const bool above0 = ratios[0][i] >= middle0, above1 = ratios[1][i] >= middle1;
        if (above0 != above1) continue;
        ++result.same;
        (above0 ? high : low).push_back(std::sqrt(ratios[0][i] * ratios[1][i]));
    }
    if (!low.empty()) result.low = median(low);
    if (!high.empty()) result.high = median(high);
    return result;
}

TEST(Evenness, SplitMcmcConvergesWorseInSomePartsThanInOthers) {
    constexpr double kLevel = 1e-3;  // error rate of each of the two decisions
    LoadOptions options;
    options.width = kWidth;
    options.height = kHeight;
    const RenderableScene scene(std::filesystem::path(METROLUX_SOURCE_DIR) / "scenes/water-sds/scene.xml",
                                options);
    const auto halves = [&](const std::string& integrator, uint64_t first) {
        return std::array{pixelVariances(scene, integrator, first),
                          pixelVariances(scene, integrator, first + kSeeds)};
    };
    const auto vcm = halves("vcm", 1);
    const Agreement split = agreement(halves("split_mcmc", 101), vcm),
                    same = agreement(halves("vcm", 101), vcm);
    for (const auto& [what, a] : {std::pair("split_mcmc", split), std::pair("vcm, other seeds", same)})
        fmt::print("| {} | {} of {} | {:.2f} | {:.2f} | {:.1e} |\n", what, a.same, a.blocks, a.low, a.high,
                   a.pValue());
    EXPECT_LT(split.pValue(), kLevel);
    EXPECT_GT(same.pValue(), kLevel) << "vcm differs from itself";
}

}  // namespace
}  // namespace metrolux::core
