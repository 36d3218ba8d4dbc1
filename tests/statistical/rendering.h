#pragma once
/// Renders by independent seeds and comparisons of their block means, with one budget for false alarms.
///
/// The program makes at most kComparisons comparisons, each at the Sidak level for a family rate of
/// kFamilyRate: a correct renderer fails with a probability below 1e-3 over the choice of the fixed seeds.
/// Errors come from the scatter between seeds alone (t-tests), as chains and shared light subpaths are
/// correlated within a seed.

#include "base/rng.h"
#include "integrators/registry.h"
#include "support/block_statistics.h"
#include "support/small_scenes.h"

#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace metrolux::core::test {

inline constexpr double kFamilyRate = 1e-3;
inline constexpr int kComparisons = 1500;
inline constexpr int kSeeds = 24;

/// Level of one comparison; counts them.
inline double comparisonLevel() {
    static int made = 0;
    EXPECT_LE(++made, kComparisons) << "raise kComparisons: the stated error rate no longer holds";
    return sidak(kFamilyRate, kComparisons);
}

struct RenderSetup {
    std::string integrator;
    int passes = 16;
    double radius = 0;  ///< merging radius of those that merge; 0: the default
    ParameterValues parameters = {};
    int columns = 3, rows = 3;
    ReconstructionFilter::Kind filter = ReconstructionFilter::Kind::Box;
    uint64_t seed = 1;
};

inline std::vector<float> renderImage(const Scene& scene, const RenderSetup& setup, uint64_t seed) {
    ParameterValues parameters = setup.parameters;
    if (ParameterSet(findIntegrator(setup.integrator).parameters).find("radius"))
        parameters["radius"] = setup.radius;
    // Chains, in scenes that are so easy that mcmc_vcm does without them.
    if (setup.integrator == "mcmc_vcm") parameters.emplace("fixed", true);
    CommonOptions options;
    options.limits = scene.parts().limits;
    options.seed = seed;
    Film film(scene.camera().window(), ReconstructionFilter(setup.filter, {}));
    const std::unique_ptr<Integrator> integrator =
        makeIntegrator(setup.integrator, scene, options, parameters);
    for (int i = 0; i < setup.passes; ++i) integrator->renderPass(film, film.passes());
    EXPECT_EQ(integrator->nonFinite(), TechniqueCounts{}) << setup.integrator;
    return film.image();
}

inline BlockStatistics renderSeeds(const Scene& scene, const RenderSetup& setup) {
    const FilmWindow& w = scene.camera().window();
    BlockStatistics statistics(w.width, w.height, setup.columns, setup.rows);
    for (int s = 0; s < kSeeds; ++s) statistics.add(renderImage(scene, setup, hashKey(setup.seed, s)));
    return statistics;
}

/// t-test of each block (green channel: the scenes are gray) against a known radiance. The smallest
/// difference that the test would nearly always see, twice the critical one, may not exceed `detectable`
/// (relative).
inline void expectRadiance(const BlockStatistics& statistics, double expected, double detectable,
                           const std::string& what) {
    const double level = comparisonLevel();
    const boost::math::students_t distribution(statistics.degreesOfFreedom());
    const double critical = boost::math::quantile(boost::math::complement(distribution, level / 2));
    double worst = 0;
    for (size_t i = 1; i < statistics.size(); i += 3) {
        if (i > 1) comparisonLevel();
        const double error = std::sqrt(statistics.varianceOfMean(i));
        EXPECT_LE(std::abs(statistics.mean(i) - expected), critical * error)
            << what << ": block " << i / 3 << " is " << statistics.mean(i) << " +- " << error << ", expected "
            << expected;
        worst = std::max(worst, 2 * critical * error / std::max(expected, 1e-9));
    }
    if (expected > 0) {
        EXPECT_LE(worst, detectable) << what << ": too noisy to decide";
    }
}

/// Welch's test of each block of two sets of renders. `detectable` as above, for the mean over blocks:
/// relative to the image's mean. Of the green channel, or of all.
inline void expectSame(const BlockStatistics& a, const BlockStatistics& b, double detectable,
                       const std::string& what, bool colors = false) {
    double sumOfCritical = 0;
    int blocks = 0;
    for (size_t i = colors ? 0 : 1; i < a.size(); i += colors ? 1 : 3) {
        const double level = comparisonLevel();
        const WelchResult r = welch(a.mean(i), a.varianceOfMean(i), a.degreesOfFreedom(), b.mean(i),
                                    b.varianceOfMean(i), b.degreesOfFreedom());
        EXPECT_GT(r.pValue, level) << what << ": "
                                   << "RGB"[i % 3] << " of block " << i / 3 << " is " << a.mean(i) << " and "
                                   << b.mean(i) << ", standard error of the difference " << r.standardError;
        if (!(r.standardError > 0)) continue;
        const boost::math::students_t distribution(r.degreesOfFreedom);
        sumOfCritical +=
            2 * r.standardError * boost::math::quantile(boost::math::complement(distribution, level / 2));
        ++blocks;
    }
    if (blocks > 0) {
        EXPECT_LE(sumOfCritical / blocks, detectable * a.total()) << what << ": too noisy to decide";
    }
}

}  // namespace metrolux::core::test
