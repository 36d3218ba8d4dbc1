/// The estimates of b_V and b_F from synthetic replicas whose normalisations are known: V has probability
/// 0.03, F is log-normal on it (deviation 1.5 of the logarithm: the square of F has a relative variance of
/// 8000).

#include "markov/normalisation.h"

#include "base/rng.h"
#include "support/goodness_of_fit.h"

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include <numbers>

namespace metrolux {
namespace {

constexpr double kVisible = 0.03, kMu = -2, kSigma = 1.5;
const double kContribution = kVisible * std::exp(kMu + 0.5 * kSigma * kSigma);
constexpr int kLanes = 16;

double normalDeviate(CounterRng& rng) {
    return std::sqrt(-2 * std::log(1 - rng.nextDouble())) * std::cos(2 * std::numbers::pi * rng.nextDouble());
}

/// All samples of a run. `held`: chains keep a value for so many steps (correlation within a lane).
Normalisation simulate(uint64_t seed, int steps, int held) {
    Normalisation n;
    for (int lane = 0; lane < kLanes; ++lane) {
        CounterRng rng(hashKey(seed, lane));
        Normalisation::Samples s;
        double v = 0, f = 0;
        for (int i = 0; i < steps; ++i) {
            s.addUniform(rng.nextDouble() < kVisible ? std::exp(kMu + kSigma * normalDeviate(rng)) : 0);
            if (i % held == 0) {
                v = std::exp(kMu + kSigma * normalDeviate(rng));
                // The density F / b_F turns a log-normal into one whose mean is shifted by the variance.
                f = std::exp(kMu + kSigma * kSigma + kSigma * normalDeviate(rng));
            }
            s.addVisibility(v);
            // Expected-value weights, and a proposal of no use.
            s.addContribution(f, 0.75);
            s.addContribution(f, 0.25);
            s.addContribution(0, 0);
        }
        n.add(lane, s);
    }
    n.update();
    return n;
}

struct Calibration {
    double bias = 0, rms = 0, claimed = 0;  ///< relative
    double pValue = 1;                      ///< that the mean of the estimates is the truth
};
template <class Read>
Calibration calibrate(const std::vector<Normalisation>& runs, double truth, Read&& read) {
    Calibration c;
    const double n = double(runs.size());
    for (const Normalisation& run : runs) {
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

TEST(Normalisation, IsRightOnAverageAndKnowsItsError) {
    for (const int held : {1, 10}) {
        std::vector<Normalisation> runs;
        for (uint64_t seed = 0; seed < 40; ++seed) runs.push_back(simulate(hashKey(held, seed), 2000, held));
        const Calibration v =
            calibrate(runs, kVisible, [](const Normalisation& n) { return n.visibilityEstimate(); });
        const Calibration f =
            calibrate(runs, kContribution, [](const Normalisation& n) { return n.contributionEstimate(); });
        for (const Calibration& c : {v, f}) {
            EXPECT_GT(c.pValue, 1e-4) << "held " << held << " bias " << c.bias << " rms " << c.rms;
            EXPECT_LT(c.rms, 0.1);
            // 40 runs: the root mean square is known to 11 % (one standard deviation), the claim with 7
            // degrees of freedom each to 4 %; a factor of 2 is beyond chance.
            EXPECT_LT(c.rms, 2 * c.claimed) << "held " << held;
            EXPECT_GT(c.rms, 0.5 * c.claimed) << "held " << held;
        }
        // Solved again from where the first solution ended: nothing moves.
        EXPECT_NEAR(runs[0].visibilityEstimate().value / runs[0].visibility(), 1, 1e-7);
        EXPECT_NEAR(runs[0].contributionEstimate().value / runs[0].contribution(), 1, 1e-7);

        // Of use only if it beats the mean over uniform samples.
        const Calibration plain = calibrate(
            runs, kContribution, [](const Normalisation& n) { return n.contributionFromUniform(); });
        EXPECT_LT(f.rms, plain.rms);
    }
}

TEST(Normalisation, IsTheFixedPointOfItsEquations) {
    // Samples of two sizes, so that the sums can be written out: b_V = sum W_j, b_F = sum F_j W_j.
    for (const double scale : {1e-20, 1.0, 1e20}) {
        Normalisation n;
        Normalisation::Samples s;
        const double small = scale, large = 50 * scale;
        for (int i = 0; i < 1000; ++i) s.addUniform(i < 40 ? small : i < 42 ? large : 0);
        for (int i = 0; i < 500; ++i) s.addVisibility(i < 470 ? small : large);
        for (int i = 0; i < 300; ++i) s.addContribution(i < 90 ? small : large, 1);
        n.add(0, s);
        n.update();
        const double bV = n.visibility(), bF = n.contribution();
        const double wSmall = 600 / (1000 + 500 / bV + 300 * small / bF),
                     wLarge = 242 / (1000 + 500 / bV + 300 * large / bF);
        EXPECT_NEAR((wSmall + wLarge) / bV, 1, 1e-6) << scale;
        EXPECT_NEAR((wSmall * small + wLarge * large) / bF, 1, 1e-6) << scale;
    }
}

TEST(Normalisation, AReplicaWithoutSamplesIsJudgedByTheOthers) {
    Normalisation n;
    CounterRng rng(6);
    Normalisation::Samples s;
    for (int i = 0; i < 100000; ++i)
        s.addUniform(rng.nextDouble() < kVisible ? std::exp(rng.nextDouble()) : 0);
    for (int i = 0; i < 100000; ++i) s.addVisibility(std::exp(rng.nextDouble()));
    n.add(0, s);
    n.update();
    EXPECT_NEAR(n.visibility(), n.visibilityFromUniform().value, 1e-9);
    EXPECT_NEAR(n.contribution() / (n.visibility() * (std::numbers::e - 1)), 1, 0.01);
}

TEST(Normalisation, InvisibleStatesOfAChainAreNoSamples) {
    // A new target can make a chain's state invisible. Counted as samples of the chain such states drove b_V
    // to 1e-9 where few uniform samples are visible (Mitsuba's roughdielectric sphere: 20 % too dark).
    Normalisation n;
    CounterRng rng(7);
    Normalisation::Samples s;
    for (int i = 0; i < 100000; ++i) s.addUniform(i % 10000 == 0 ? std::exp(rng.nextDouble()) : 0);
    for (int i = 0; i < 10000; ++i) s.addVisibility(std::exp(rng.nextDouble()));
    for (int i = 0; i < 10000; ++i) s.addContribution(i % 4 == 0 ? 0 : std::exp(rng.nextDouble()), 1);
    n.add(0, s);
    n.update();
    EXPECT_NEAR(n.visibility(), 1e-4, 1e-9);
}

TEST(Normalisation, DiscountedSamplesWeighLess) {
    Normalisation n;
    Normalisation::Samples old, recent;
    for (int i = 0; i < 1000; ++i) {
        old.addUniform(i % 2 == 0 ? 8 : 0);
        recent.addUniform(i % 10 == 0 ? 2 : 0);
    }
    n.add(0, old);
    n.discount(0.25);
    n.add(0, recent);
    n.update();
    EXPECT_NEAR(n.visibility(), (0.25 * 0.5 + 0.1) / 1.25, 1e-6);
    EXPECT_NEAR(n.contribution(), (0.25 * 4 + 0.2) / 1.25, 1e-6);
    n.forget();
    n.update();
    EXPECT_NEAR(n.contribution(), (0.25 * 4 + 0.2) / 1.25, 1e-6);  // kept until there are new samples
}

TEST(Normalisation, ClassicEstimatesAgree) {
    const Normalisation n = simulate(77, 20000, 1);
    const Estimate v = n.visibilityFromUniform(), f = n.contributionFromUniform();
    EXPECT_LT(std::abs(v.value - kVisible), 5 * v.standardError);
    EXPECT_LT(std::abs(f.value - kContribution), 6 * f.standardError);
    EXPECT_NEAR(n.contributionFromVisibility() / kContribution, 1, 0.15);
}

TEST(Normalisation, UniformSamplesAloneGiveTheirMeans) {
    Normalisation n;
    CounterRng rng(5);
    double visible = 0, size = 0;
    for (int lane = 0; lane < 8; ++lane) {
        Normalisation::Samples s;
        for (int i = 0; i < 1000; ++i) {
            const double x = rng.nextDouble() < 0.2 ? std::exp(4 * rng.nextDouble()) : 0;
            visible += x > 0 ? 1 / 8000.0 : 0;
            size += x / 8000;
            s.addUniform(x);
        }
        n.add(lane, s);
    }
    n.update();
    EXPECT_NEAR(n.visibility(), visible, 1e-6 * visible);
    EXPECT_NEAR(n.contribution(), size, 1e-6 * size);
    EXPECT_NEAR(n.visibilityEstimate().standardError, std::sqrt(0.2 * 0.8 / 8000), 0.003);
}

TEST(Normalisation, KnowsNothingWithoutVisibleOrUniformSamples) {
    Normalisation n;
    n.update();
    EXPECT_EQ(n.visibility(), 1);
    EXPECT_EQ(n.contribution(), 1);
    EXPECT_TRUE(std::isinf(n.visibilityFromUniform().standardError));
    Normalisation::Samples dark;
    for (int i = 0; i < 100; ++i) dark.addUniform(0);
    n.add(0, dark);
    n.update();
    EXPECT_TRUE(std::isfinite(n.visibility()));
    EXPECT_TRUE(std::isinf(n.visibilityEstimate().standardError));  // groups without samples

    Normalisation chainsOnly;
    Normalisation::Samples s;
    for (int i = 0; i < 100; ++i) s.addVisibility(2.0), s.addContribution(3.0, 1);
    chainsOnly.add(0, s);
    chainsOnly.update();
    EXPECT_EQ(chainsOnly.visibility(), 1);
    EXPECT_EQ(chainsOnly.contribution(), 1);
}

TEST(Normalisation, ClearedSamplesAreEmpty) {
    Normalisation::Samples s;
    s.addUniform(1);
    s.addVisibility(2);
    s.addContribution(3, 1);
    s.clear();
    Normalisation n;
    n.add(0, s);
    n.update();
    EXPECT_EQ(n.visibility(), 1);
    EXPECT_EQ(n.visibilityFromUniform().value, 0);
}

TEST(Normalisation, ExtremeSizesAreFinite) {
    Normalisation n;
    Normalisation::Samples s;
    for (const double size : {1e-37, 1e-10, 1.0, 1e10, 1e37}) {
        s.addUniform(size);
        s.addVisibility(size);
        s.addContribution(size, 1);
    }
    n.add(0, s);
    n.update();
    EXPECT_TRUE(n.visibility() > 0 && n.visibility() <= 1);
    EXPECT_TRUE(std::isfinite(n.contribution()) && n.contribution() > 0);
}

}  // namespace
}  // namespace metrolux
