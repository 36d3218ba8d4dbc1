/// The estimates of b_V and b_F from synthetic replicas whose normalizations are known: V has probability
/// 0.03, F is log-normal on it (deviation 1.5 of the logarithm: the square of F has a relative variance of
/// 8000).

#include "markov/normalization.h"

#include "base/rng.h"
#include "support/goodness_of_fit.h"

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include <numbers>

namespace metrolux::core {
namespace {

constexpr double kVisible = 0.03, kMu = -2, kSigma = 1.5;
const double kContribution = kVisible * std::exp(kMu + 0.5 * kSigma * kSigma);
constexpr int kLanes = 16;

double normalDeviate(CounterRng& rng) {
    return std::sqrt(-2 * std::log(1 - rng.nextDouble())) * std::cos(2 * std::numbers::pi * rng.nextDouble());
}

/// All samples of a run. `held`: chains keep a value for so many steps (correlation within a lane).
Normalization simulate(uint64_t seed, int steps, int held) {
    Normalization n;
    for (int lane = 0; lane < kLanes; ++lane) {
        CounterRng rng(hashKey(seed, lane));
        Normalization::Samples s;
        double v = 0;
        for (int i = 0; i < steps; ++i) {
            s.addUniform(rng.nextDouble() < kVisible ? std::exp(kMu + kSigma * normalDeviate(rng)) : 0);
            if (i % held == 0) v = std::exp(kMu + kSigma * normalDeviate(rng));
            s.addVisibility(v);
        }
        n.add(lane, s);
    }
    n.endIteration(1);
    n.update(1);
    return n;
}

struct Calibration {
    double bias = 0, rms = 0, claimed = 0;  ///< relative
    double pValue = 1;                      ///< that the mean of the estimates is the truth
};
template <class Read>
Calibration calibrate(const std::vector<Normalization>& runs, double truth, Read&& read) {
    Calibration c;
    const double n = double(runs.size());
    for (const Normalization& run : runs) {
        const Estimate e = read(run);
        const double error = e.value / truth - 1;
        c.bias += error / n;
        c.rms += error * error / n;
        c.claimed += sqr(e.standardError / truth) / n;
    }
    const double deviation = std::sqrt((c.rms - c.bias * c.bias) / (n - 1));
    c.pValue = 2 * boost::math::cdf(
                       boost::math::complement(boost::math::students_t(n - 1), std::abs(c.bias) / deviation));
    c.rms = std::sqrt(c.rms);
    c.claimed = std::sqrt(c.claimed);
    return c;
}

TEST(Normalization, IsRightOnAverageAndKnowsItsError) {
    for (const int held : {1, 10}) {
        std::vector<Normalization> runs;
        for (uint64_t seed = 0; seed < 40; ++seed) runs.push_back(simulate(hashKey(held, seed), 2000, held));
        const Calibration v =
            calibrate(runs, kVisible, [](const Normalization& n) { return n.visibilityEstimate(); });
        const Calibration f =
            calibrate(runs, kContribution, [](const Normalization& n) { return n.contributionEstimate(); });
        for (const Calibration& c : {v, f}) {
            EXPECT_GT(c.pValue, 1e-4) << "held " << held << " bias " << c.bias << " rms " << c.rms;
            EXPECT_LT(c.rms, 0.1);
            // 40 runs: the root mean square is known to 11 % (one standard deviation), the claim with 7
            // degrees of freedom each to 4 %; a factor of 2 is beyond chance.
            EXPECT_LT(c.rms, 2 * c.claimed) << "held " << held;
            EXPECT_GT(c.rms, 0.5 * c.claimed) << "held " << held;
        }
        // Of use only if it beats the mean of F over the uniform samples alone.
        const double plain = std::sqrt((std::exp(kSigma * kSigma) / kVisible - 1) / (kLanes * 2000.0));
        EXPECT_LT(f.rms, plain);
    }
}

TEST(Normalization, FollowsAPowerOfTheRadius) {
    // r^2 ~ i^-1/4 as [HPJ12] has it; V ~ r^2, mean of F over it ~ 1 / r^2. Counts are their expectations: no
    // noise.
    Normalization n;
    constexpr int kIterations = 1000;  // more than the records that are kept apart
    constexpr int kSamples = 100000;
    for (int i = 1; i <= kIterations; ++i) {
        const double r2 = std::pow(i, -0.25);
        Normalization::Samples s;
        const int visible = int(std::lround(0.1 * kSamples * r2));
        for (int k = 0; k < kSamples / 10; ++k) s.addUniform(k < visible / 10 ? 3 / r2 : 0);
        for (int k = 0; k < 100; ++k) s.addVisibility(3 / r2);
        n.add(0, s);
        n.endIteration(r2);
        n.update(r2);
        // Whole numbers of visible samples: 1 in 178 at least.
        EXPECT_NEAR(n.visibility() / (0.1 * r2), 1, 0.006) << i;
        EXPECT_NEAR(n.contribution() / 0.3, 1, 0.006) << i;
    }
}

TEST(Normalization, ForgetsSizesButNotWhatWasVisible) {
    Normalization n;
    const auto iteration = [&](double size) {
        Normalization::Samples s;
        for (int i = 0; i < 100; ++i) s.addUniform(i < 10 ? size : 0);
        n.add(0, s);
        n.endIteration(1);
    };
    iteration(100);
    EXPECT_EQ(n.visibleSamples(), 10);
    n.forgetSizes();
    EXPECT_EQ(n.visibleSamples(), 0);
    n.update(1);  // no sizes: what was known stays
    EXPECT_EQ(n.visibility(), 1);
    iteration(2);
    n.update(1);
    EXPECT_NEAR(n.visibility(), 0.1, 1e-12);
    EXPECT_NEAR(n.contribution(), 0.2, 1e-12);
}

TEST(Normalization, FitTrend) {
    std::vector<TrendPoint> points;
    for (const double x : {0.0, -0.1, -0.3, -0.35})
        points.push_back({x, 50, 50 * std::exp(-1 + 0.7 * x), 1 - x});
    EXPECT_NEAR(fitTrend(points, -0.5, 0, 1), std::exp(-1.35), 1e-8);
    // At the bound the ratio of the sums decides.
    double count = 0, exposure = 0;
    for (const TrendPoint& p : points) count += p.weight * p.count, exposure += p.weight * p.exposure;
    EXPECT_NEAR(fitTrend(points, -0.5, -1, 0), count / exposure, 1e-12);
    EXPECT_EQ(fitTrend({}, 0, 0, 1), 0);
    EXPECT_EQ(fitTrend({{0, 10, 0, 1}, {-1, 10, 0, 1}}, 0, 0, 1), 0);
    // One point, or none that differ in x: no trend to see.
    EXPECT_NEAR(fitTrend({{-2, 10, 5, 1}}, -2, 0, 1), 0.5, 1e-12);
}

TEST(Normalization, KnowsNothingWithoutVisibleOrUniformSamples) {
    Normalization n;
    n.update(1);
    EXPECT_EQ(n.visibility(), 1);
    EXPECT_EQ(n.contribution(), 1);
    Normalization::Samples dark;
    for (int i = 0; i < 100; ++i) dark.addUniform(0);
    n.add(0, dark);
    n.endIteration(1);
    n.update(1);
    EXPECT_TRUE(std::isfinite(n.visibility()));
    EXPECT_TRUE(std::isinf(n.visibilityEstimate().standardError));  // groups without samples

    Normalization chainsOnly;
    Normalization::Samples s;
    for (int i = 0; i < 100; ++i) s.addVisibility(2.0);
    chainsOnly.add(0, s);
    chainsOnly.endIteration(1);
    chainsOnly.update(1);
    EXPECT_EQ(chainsOnly.visibility(), 1);
    EXPECT_EQ(chainsOnly.contribution(), 1);
}

TEST(Normalization, ClearedSamplesAreEmpty) {
    Normalization::Samples s;
    s.addUniform(1);
    s.addVisibility(2);
    s.clear();
    Normalization n;
    n.add(0, s);
    n.endIteration(1);
    n.update(1);
    EXPECT_EQ(n.visibility(), 1);
    EXPECT_EQ(n.visibleSamples(), 0);
}

TEST(Normalization, ExtremeSizesAreFinite) {
    Normalization n;
    Normalization::Samples s;
    for (const double size : {1e-37, 1e-10, 1.0, 1e10, 1e37}) {
        s.addUniform(size);
        s.addVisibility(size);
    }
    n.add(0, s);
    n.endIteration(1);
    n.update(1);
    EXPECT_TRUE(n.visibility() > 0 && n.visibility() <= 1);
    EXPECT_TRUE(std::isfinite(n.contribution()) && n.contribution() > 0);
}

/// F under v: log-normal, E[F] = exp(s^2 / 2); under v F the logarithm is normal about s^2.
struct LogNormal {
    double sigma;
    uint64_t key;
    SizeHistogram histogram(int samples, double mean) const {
        CounterRng rng(key);
        SizeHistogram h;
        for (int i = 0; i < samples; ++i) {
            const double radius = std::sqrt(-2 * std::log(1 - rng.nextDouble())),
                         normal = radius * std::cos(2 * std::numbers::pi * rng.nextDouble());
            h.add(std::exp(mean + sigma * normal));
        }
        return h;
    }
};

TEST(BennettMean, IsTheMeanAndBetterThanThePlainOne) {
    constexpr double kSpread = 2;
    constexpr int kRepetitions = 64, kSamples = 2000;
    const double exact = std::exp(kSpread * kSpread / 2);
    double sum = 0, squared = 0, plainSquared = 0;
    for (uint64_t k = 0; k < kRepetitions; ++k) {
        const SizeHistogram v = LogNormal{kSpread, hashKey(1, k)}.histogram(kSamples, 0),
                            f = LogNormal{kSpread, hashKey(2, k)}.histogram(kSamples, kSpread * kSpread);
        const double error = bennettMean(v, f) / exact - 1, plain = bennettMean(v, {}) / exact - 1;
        sum += error;
        squared += error * error;
        plainSquared += plain * plain;
    }
    const double mean = sum / kRepetitions, rms = std::sqrt(squared / kRepetitions);
    // Bins are a tenth wide: their middle is off by less than 1 %.
    EXPECT_LT(std::abs(mean), 4 * rms / std::sqrt(kRepetitions) + 0.01);
    EXPECT_LT(rms, 0.5 * std::sqrt(plainSquared / kRepetitions));
}

TEST(BennettMean, OfNothingIsZero) {
    SizeHistogram some;
    some.add(3);
    EXPECT_EQ(bennettMean({}, {}), 0);
    EXPECT_EQ(bennettMean({}, some), 0);
    EXPECT_NEAR(bennettMean(some, {}), 3, 0.15);
    EXPECT_NEAR(bennettMean(some, some), 3, 0.15);
}

TEST(Normalization, BennettsRatioUsesTheContributionReplica) {
    Normalization n(NormalizationMethod::Bennett);
    // Half of the uniform samples are visible, with sizes 1 and 16 alike often: the mean is 8.5, and the
    // contribution replica visits 16 in 16 of 17 steps. Uniform samples have missed most of the large ones.
    for (int i = 0; i < 200; ++i) {
        Normalization::Samples s = n.newSamples();
        for (int k = 0; k < 34; ++k) s.addUniform(0);
        for (int k = 0; k < 34; ++k) s.addUniform(k % 2 ? 1 : 16);
        for (int k = 0; k < 340; ++k) s.addContribution(k % 17 ? 16 : 1);
        n.add(i % 8, s);
        n.endIteration(1);
    }
    n.update(1);
    EXPECT_NEAR(n.visibility(), 0.5, 1e-9);
    EXPECT_NEAR(n.contribution(), 0.5 * 8.5, 0.05 * 4.25);
}

}  // namespace
}  // namespace metrolux::core
