/// The sampler of PSSMLT on an integrand that can be integrated by hand: its estimates are unbiased from the
/// first step with any pool, and its books balance. Independent replicates give an exact t-test.

#include "markov/metropolis.h"

#include "support/goodness_of_fit.h"

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include <array>
#include <cstring>

namespace metrolux::core {
namespace {

using test::chiSquarePValue;
using test::kLevel;
using Kind = MutationKernel::Kind;

struct Value {
    std::array<double, 2> pixels{};
    double size = 0;
};
using Sampler = MetropolisSampler<Value>;

/// A wide dim band for one pixel, and a small bright spot for the other; nothing elsewhere.
void evaluate(SampleStream& stream, Value& v) {
    stream.seek(0);
    const Vec2f u = stream.next2D();
    v.pixels = {u.x < 0.5f ? 1.0 + u.y : 0.0, u.x > 0.9f && u.y < 0.1f ? 30.0 : 0.0};
    v.size = v.pixels[0] + v.pixels[1];
}
constexpr std::array<double, 2> kIntegral{0.75, 0.3};
constexpr double kNormalization = 1.05;

/// Options with few samples, so that every error of the start shows.
MetropolisOptions options(uint64_t key, double largeStep, Kind kind = Kind::Kelemen) {
    MetropolisOptions o;
    o.key = key;
    o.lanes = 2;
    o.kind = kind;
    o.largeStep = largeStep;
    o.steeringSamples = 8;
    o.poolSamples = 12;
    return o;
}

struct Moments {
    double n = 0, sum = 0, squares = 0;
    void add(double x) {
        ++n;
        sum += x;
        squares += x * x;
    }
    double pValue(double expected) const {
        const double mean = sum / n, variance = (squares / n - mean * mean) / (n - 1);
        const boost::math::students_t distribution(n - 1);
        const double t = std::abs(mean - expected) / std::sqrt(variance);
        return 2 * boost::math::cdf(boost::math::complement(distribution, t));
    }
};

/// Sums of one call; lanes are served one after the other, so that a plain sum is safe.
std::array<double, 2> integral(Sampler& sampler, size_t steps, bool anew) {
    std::array<double, 2> sum{};
    const auto pay = [&](const Value& v, double weight) {
        for (int k = 0; k < 2; ++k) sum[k] += weight * v.pixels[k];
    };
    tbb::task_arena serial(1);
    serial.execute([&] {
        if (anew)
            sampler.integrateAnew(steps / 2, steps, evaluate, pay);
        else
            sampler.integrate(steps, evaluate, pay);
    });
    return sum;
}

class Unbiased : public testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(Unbiased, FromTheFirstStepWithAnyPool) {
    constexpr int kReplicates = 40000, kCalls = 6;
    const auto [largeStep, anew] = GetParam();
    std::array<std::array<Moments, 2>, kCalls> moments;
    for (int r = 0; r < kReplicates; ++r) {
        Sampler sampler(options(hashKey(11, r), largeStep));
        for (int call = 0; call < kCalls; ++call) {
            const auto sum = integral(sampler, 6, anew);
            for (int k = 0; k < 2; ++k) moments[call][k].add(sum[k]);
        }
    }
    for (const int call : {0, 1, kCalls - 1})
        for (int k = 0; k < 2; ++k)
            EXPECT_GT(moments[call][k].pValue(kIntegral[k]), kLevel)
                << "call " << call << ", pixel " << k << ": " << moments[call][k].sum / kReplicates
                << ", expected " << kIntegral[k];
}

INSTANTIATE_TEST_SUITE_P(LargeStepsAndTargets, Unbiased,
                         testing::Combine(testing::Values(0.0, 0.3, 1.0), testing::Bool()));

TEST(MetropolisSampler, WithoutStartUpWeightsTheBiasWouldBeSeen) {
    // The power of the test above: chains from the same starts with the exact normalization in place of the
    // pool's mean.
    Moments naive, weighted;
    for (int r = 0; r < 40000; ++r) {
        Sampler sampler(options(hashKey(12, r), 0));
        const double sum = integral(sampler, 6, false)[1];
        if (sampler.pool().empty()) continue;
        naive.add(sum * kNormalization / sampler.pool().mean());
        weighted.add(sum);
    }
    EXPECT_LT(naive.pValue(kIntegral[1]), kLevel);
}

/// The spot needs a second coordinate, the dim rest of the line does not, so that chains meet coordinates
/// that their state has not got.
void evaluateRagged(SampleStream& stream, Value& v) {
    stream.seek(0);
    const bool dim = stream.next1D() < 0.5f;
    v.pixels = {dim ? 1.5 : 0.0, !dim && stream.next1D() < 0.05f ? 12.0 : 0.0};
    v.size = v.pixels[0] + v.pixels[1];
}
constexpr std::array<double, 2> kRaggedIntegral{0.75, 0.3};

/// Moments of what a call of 160 steps returns.
std::array<Moments, 2> raggedIntegral(Kind kind, double largeStep, uint64_t training, int replicates) {
    std::array<Moments, 2> moments;
    for (int r = 0; r < replicates; ++r) {
        MetropolisOptions o = options(hashKey(13, r), largeStep, kind);
        o.trainingMutations = training;
        Sampler sampler(o);
        std::array<double, 2> sum{};
        tbb::task_arena serial(1);
        serial.execute([&] {
            sampler.integrate(160, evaluateRagged, [&](const Value& v, double weight) {
                for (int k = 0; k < 2; ++k) sum[k] += weight * v.pixels[k];
            });
        });
        for (int k = 0; k < 2; ++k) moments[k].add(sum[k]);
    }
    return moments;
}

class Ragged : public testing::TestWithParam<std::tuple<Kind, double>> {};

TEST_P(Ragged, UnbiasedWhereSomePathsNeedMoreCoordinates) {
    const auto [kind, largeStep] = GetParam();
    const auto moments = raggedIntegral(kind, largeStep, 64, 20000);
    for (int k = 0; k < 2; ++k)
        EXPECT_GT(moments[k].pValue(kRaggedIntegral[k]), kLevel)
            << "pixel " << k << ": " << moments[k].sum / moments[k].n << ", expected " << kRaggedIntegral[k];
}

INSTANTIATE_TEST_SUITE_P(KernelsAndLargeSteps, Ragged,
                         testing::Combine(testing::Values(Kind::Kelemen, Kind::Adaptive),
                                          testing::Values(0.0, 0.3)));

TEST(MetropolisSampler, AdaptingWhileItCountsWouldBeSeen) {
    const auto moments = raggedIntegral(Kind::Adaptive, 0, MutationKernel::kAlways, 20000);
    EXPECT_LT(moments[1].pValue(kRaggedIntegral[1]), kLevel);
}

TEST(MetropolisSampler, PaysOutEveryMutationOnceTheLastStateIncluded) {
    // Weights are normalization / (n F): times F, each of the n mutations pays one n-th of the normalization,
    // shared by the proposal and the state.
    for (const Kind kind : {Kind::Kelemen, Kind::Adaptive}) {
        Sampler sampler(options(5, 0, kind));
        for (const size_t steps : {1, 2, 3, 17, 1000}) {
            double paid = 0;
            tbb::task_arena serial(1);
            serial.execute([&] {
                sampler.integrate(steps, evaluate,
                                  [&](const Value& v, double weight) { paid += weight * v.size; });
            });
            ASSERT_FALSE(sampler.pool().empty());
            EXPECT_NEAR(paid / sampler.pool().mean(), 1, 1e-12) << steps;
        }
    }
}

TEST(MetropolisSampler, CopiedContinuesBitForBit) {
    for (const Kind kind : {Kind::Kelemen, Kind::Adaptive})
        for (const bool anew : {false, true}) {
            Sampler sampler(options(6, 0.3, kind));
            for (int i = 0; i < 3; ++i) integral(sampler, 50, anew);
            Sampler copy = sampler;
            bool moved = false;
            for (int i = 0; i < 4; ++i) {
                const auto a = integral(sampler, 50, anew), b = integral(copy, 50, anew);
                ASSERT_EQ(std::memcmp(&a, &b, sizeof a), 0);
                moved |= a[0] > 0;
            }
            EXPECT_TRUE(moved);
            EXPECT_EQ(sampler.counts().largeAccepted, copy.counts().largeAccepted);
        }
}

TEST(MetropolisSampler, NormalizationComesFromAllUniformSamplesAndConverges) {
    Moments deviations;
    for (int r = 0; r < 400; ++r) {
        Sampler sampler(options(hashKey(7, r), 0.5));
        const size_t drawnBefore = 12;
        for (int i = 0; i < 4; ++i) integral(sampler, 500, false);
        const StartPool& pool = sampler.pool();
        EXPECT_EQ(pool.drawn(), drawnBefore + sampler.counts().largeTried);
        EXPECT_GE(sampler.counts().starts, 2u) << "chains start anew when the pool has doubled";
        deviations.add((pool.mean() - kNormalization) / pool.standardError());
    }
    const double mean = deviations.sum / deviations.n;
    EXPECT_LT(std::abs(mean), 0.25);  // five standard errors
    EXPECT_NEAR(deviations.squares / deviations.n, 1, 0.45);
}

TEST(MetropolisSampler, BlackIntegrandsPayNothing) {
    Sampler sampler(options(8, 0.3));
    for (int i = 0; i < 3; ++i)
        sampler.integrate(
            20, [](SampleStream&, Value& v) { v = {}; }, [](const Value&, double) { FAIL(); });
    EXPECT_EQ(sampler.counts().starts, 0u);
}

TEST(StartPool, SlotsAreDrawnInProportionOverAllBatches) {
    const std::vector<UniformSample> first{{0, 1}, {1, 3}, {2, 0.5}}, second{{3, 2}, {4, 6}};
    const double total = 12.5;
    std::vector<double> counts(5), expected;
    constexpr int kRuns = 20000;
    for (int r = 0; r < kRuns; ++r) {
        // One slot: slots of one pool are not independent.
        CounterRng rng(hashKey(3, r));
        StartPool pool(1);
        pool.add(first, 10, rng);
        pool.add({}, 5, rng);
        pool.add(second, 5, rng);
        EXPECT_DOUBLE_EQ(pool.mean(), total / 20);
        ++counts[pool.key(0)];
    }
    for (const double size : {1.0, 3.0, 0.5, 2.0, 6.0}) expected.push_back(kRuns * size / total);
    EXPECT_GT(chiSquarePValue(counts, expected), kLevel);
}

}  // namespace
}  // namespace metrolux::core
