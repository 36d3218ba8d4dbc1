#include "markov/mutation.h"

#include "base/math.h"
#include "support/goodness_of_fit.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using test::chiSquarePValue;
using test::kLevel;

using Kind = MutationKernel::Kind;

/// A kernel whose theta has been driven below `theta` by rejections.
MutationKernel kernelWithTheta(double theta) {
    MutationKernel kernel(Kind::Adaptive);
    while (kernel.theta() > theta && kernel.tried() < 1000) kernel.adapt(false);
    return kernel;
}

std::vector<MutationKernel> kernels() {
    return {MutationKernel(Kind::Adaptive), kernelWithTheta(0.4), kernelWithTheta(0.1),
            MutationKernel(Kind::Kelemen)};
}

TEST(Mutation, StepsAreSymmetric) {
    // Steps on the circle against their negatives, in bins of a quarter octave from 1e-5: smaller ones drown
    // in rounding.
    constexpr int kSteps = 400000;
    constexpr double kSmallest = 1e-5;
    for (const MutationKernel& kernel : kernels()) {
        CounterRng rng(1);
        const PrimarySample from = {0.5f};
        PrimarySample to;
        std::vector<double> positive(80), negative(80);
        for (int i = 0; i < kSteps; ++i) {
            kernel.mutate(from, to, rng);
            double d = double(to[0]) - from[0];
            if (std::abs(d) < kSmallest) continue;
            const int bin = static_cast<int>(4 * std::log2(std::abs(d) / kSmallest));
            (d > 0 ? positive : negative)[bin] += 1;
        }
        std::vector<double> expected(positive.size());
        for (size_t i = 0; i < expected.size(); ++i) expected[i] = 0.5 * (positive[i] + negative[i]);
        // (n+ - n-)^2 / (n+ + n-) has one degree of freedom: twice the statistic of n+ against the mean.
        double statistic = 0;
        int bins = 0;
        for (size_t i = 0; i < expected.size(); ++i) {
            if (expected[i] < 5) continue;
            statistic += sqr(positive[i] - negative[i]) / (positive[i] + negative[i]);
            ++bins;
        }
        ASSERT_GT(bins, 10);
        EXPECT_GT(boost::math::cdf(boost::math::complement(boost::math::chi_squared(bins), statistic)),
                  kLevel)
            << "theta " << kernel.theta();
    }
}

TEST(Mutation, StepsFollowTheirDensities) {
    constexpr int kSteps = 200000;
    CounterRng rng(2);
    PrimarySample to;
    // Kelemen: log-uniform between 1/1024 and 1/64.
    std::vector<double> bins(16);
    for (int i = 0; i < kSteps; ++i) {
        MutationKernel(Kind::Kelemen).mutate({0.5f}, to, rng);
        const double t = std::log2(std::abs(double(to[0]) - 0.5) * 1024) / 4;
        ASSERT_TRUE(t > -1e-3 && t < 1 + 1e-3);
        bins[std::clamp(static_cast<int>(t * 16), 0, 15)] += 1;
    }
    EXPECT_GT(chiSquarePValue(bins), kLevel);
    // Adaptive: magnitude^theta is uniform (eq. 4); seen from 0 a positive step below 1/2 is the new
    // coordinate itself.
    const MutationKernel kernel = kernelWithTheta(0.4);
    const double theta = kernel.theta(), half = std::pow(0.5, theta);
    std::vector<double> observed(16), expected(16);
    for (int i = 0; i < kSteps; ++i) {
        kernel.mutate({0.0f}, to, rng);
        if (to[0] < 0.5f) observed[static_cast<size_t>(std::pow(double(to[0]), theta) / half * 16)] += 1;
    }
    for (int b = 0; b < 16; ++b) {
        // Positive steps below 1/2, and negative ones beyond 1/2 that come around.
        const double low = std::pow(b / 16.0, 1 / theta) * 0.5,
                     high = std::pow((b + 1) / 16.0, 1 / theta) * 0.5;
        const auto cdf = [&](double x) { return std::pow(x, theta); };
        expected[b] = 0.5 * kSteps * (cdf(high) - cdf(low) + cdf(1 - low) - cdf(1 - high));
    }
    double total = 0, seen = 0;
    for (int b = 0; b < 16; ++b) total += expected[b], seen += observed[b];
    EXPECT_GT(test::normalPValue((seen - total) / std::sqrt(total * (1 - total / kSteps))), kLevel);
    for (double& e : expected) e *= seen / total;
    EXPECT_GT(chiSquarePValue(observed, expected), kLevel);
}

TEST(Mutation, ThetaOneIsTheUniformJump) {
    CounterRng rng(3);
    std::vector<double> counts(64);
    PrimarySample to;
    for (int i = 0; i < 100000; ++i) {
        MutationKernel(Kind::Adaptive).mutate({0.123f}, to, rng);
        counts[static_cast<size_t>(to[0] * 64)] += 1;
    }
    EXPECT_GT(chiSquarePValue(counts), kLevel);
}

TEST(Mutation, UniformStatesStayUniformAndCoordinatesIndependent) {
    constexpr int kBins = 24, kSamples = 300000;
    for (const MutationKernel& kernel : kernels()) {
        CounterRng rng(4);
        PrimarySample from(2), to;
        std::vector<double> counts(kBins * kBins);
        for (int i = 0; i < kSamples; ++i) {
            from = {rng.next1D(), rng.next1D()};
            kernel.mutate(from, to, rng);
            ASSERT_EQ(to.size(), from.size());
            counts[static_cast<int>(to[1] * kBins) * kBins + static_cast<int>(to[0] * kBins)] += 1;
        }
        EXPECT_GT(chiSquarePValue(counts), kLevel) << "theta " << kernel.theta();
    }
}

TEST(Mutation, CoordinatesNeverLeaveTheUnitInterval) {
    for (const MutationKernel& kernel : kernels()) {
        CounterRng rng(5);
        const PrimarySample from = {0, kOneMinusEpsilon, 0x1p-30f, 0.5f, 1 - 0x1p-12f};
        PrimarySample to;
        for (int i = 0; i < 50000; ++i) {
            kernel.mutate(from, to, rng);
            for (const float x : to) ASSERT_TRUE(x >= 0 && x < 1) << x;
        }
    }
    EXPECT_EQ(wrapUnit(-1e-12f), kOneMinusEpsilon);
    EXPECT_EQ(wrapUnit(1.25f), 0.25f);
    EXPECT_EQ(wrapUnit(-0.25f), 0.75f);
    EXPECT_EQ(wrapUnit(1.0f), 0);
    EXPECT_EQ(wrapUnit(-1.0f), 0);
    EXPECT_EQ(wrapUnit(2.0f), 0);
}

TEST(Mutation, ThetaFollowsEquationFiveWithinItsLimits) {
    MutationKernel kernel(Kind::Adaptive);
    EXPECT_EQ(kernel.theta(), MutationKernel::kMaximalTheta);
    kernel.adapt(true);
    EXPECT_EQ(kernel.theta(), MutationKernel::kMaximalTheta);  // clamped
    kernel.adapt(false);
    kernel.adapt(false);
    kernel.adapt(false);
    // A = 1/2, 1/3, 1/4 are all above the goal: still at the limit; 1/5 is the first below it.
    EXPECT_EQ(kernel.theta(), MutationKernel::kMaximalTheta);
    kernel.adapt(false);
    EXPECT_NEAR(kernel.theta(), 1 + (0.2 - 0.234) / 5, 1e-12);
    EXPECT_EQ(kernel.tried(), 5u);
    EXPECT_EQ(kernel.accepted(), 1u);
    for (int i = 0; i < 100000; ++i) kernel.adapt(false);
    EXPECT_EQ(kernel.theta(), MutationKernel::kMinimalTheta);

    MutationKernel kelemen(Kind::Kelemen);
    for (int i = 0; i < 100; ++i) kelemen.adapt(i % 2 == 0);
    EXPECT_EQ(kelemen.theta(), MutationKernel::kMaximalTheta);  // not adapted, but counted
    EXPECT_DOUBLE_EQ(kelemen.acceptance(), 0.5);
}

TEST(Mutation, SharedThetaIsTheMean) {
    std::vector<MutationKernel> kernels(3, MutationKernel(Kind::Adaptive));
    for (int i = 0; i < 1000; ++i) kernels[1].adapt(i % 50 == 0);
    for (int i = 0; i < 1000; ++i) kernels[2].adapt(i % 10 == 0);
    const double mean = (kernels[0].theta() + kernels[1].theta() + kernels[2].theta()) / 3;
    ASSERT_LT(kernels[1].theta(), kernels[2].theta());
    MutationKernel::shareTheta({&kernels[0], &kernels[1], &kernels[2]});
    for (const MutationKernel& k : kernels) EXPECT_DOUBLE_EQ(k.theta(), mean);
    EXPECT_EQ(kernels[1].tried(), 1000u);
}

}  // namespace
}  // namespace metrolux::core
