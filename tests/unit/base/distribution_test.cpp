#include "base/distribution.h"

#include "base/error.h"
#include "base/rng.h"
#include "support/goodness_of_fit.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using test::chiSquarePValue;
using test::kLevel;

TEST(DiscreteDistribution, SamplesFollowTheWeightsAndTheRestOfUIsUniform) {
    const std::vector<double> weights = {0, 3, 1, 0, 0.5, 10, 0, 2, 0};
    const DiscreteDistribution d(weights);
    EXPECT_EQ(d.size(), weights.size());
    EXPECT_DOUBLE_EQ(d.sum(), 16.5);
    constexpr int kSamples = 200000, kBins = 8;
    std::vector<double> observed(weights.size() * kBins), expected(observed.size());
    CounterRng rng(11);
    for (int i = 0; i < kSamples; ++i) {
        float u = rng.next1D();
        const size_t index = d.sample(u);
        ASSERT_TRUE(u >= 0 && u < 1);
        observed[index * kBins + static_cast<size_t>(u * kBins)] += 1;
    }
    for (size_t i = 0; i < weights.size(); ++i) {
        EXPECT_NEAR(d.pmf(i), weights[i] / 16.5, 1e-12);
        for (int b = 0; b < kBins; ++b) expected[i * kBins + b] = kSamples * weights[i] / 16.5 / kBins;
    }
    EXPECT_GT(chiSquarePValue(observed, expected), kLevel);
}

TEST(DiscreteDistribution, WeightsOfZeroAreNeverPicked) {
    CounterRng rng(12);
    for (int trial = 0; trial < 300; ++trial) {
        std::vector<double> weights(1 + rng.nextBits() % 40);
        for (double& w : weights) w = rng.next1D() < 0.6f ? 0.0 : std::exp(20 * (rng.nextDouble() - 0.5));
        const DiscreteDistribution d(weights);
        if (d.empty()) continue;
        std::vector<float> us = {0, kOneMinusEpsilon, 0.5f};
        double cdf = 0;
        for (size_t i = 0; i < weights.size(); ++i) {  // around each boundary
            cdf += d.pmf(i);
            const float u = static_cast<float>(cdf);
            for (const float v : {u, std::nextafter(u, 0.0f), std::nextafter(u, 2.0f)})
                if (v < 1) us.push_back(v);
        }
        for (const float start : us) {
            float u = start;
            const size_t i = d.sample(u);
            ASSERT_LT(i, weights.size());
            ASSERT_GT(weights[i], 0) << "u = " << start;
            ASSERT_GT(d.pmf(i), 0);
            ASSERT_TRUE(u >= 0 && u < 1);
        }
    }
}

TEST(DiscreteDistribution, ProbabilitiesSumToOne) {
    CounterRng rng(13);
    std::vector<double> weights(1000);
    for (double& w : weights) w = std::exp(60 * rng.nextDouble());
    const DiscreteDistribution d(weights);
    double sum = 0;
    for (size_t i = 0; i < d.size(); ++i) sum += d.pmf(i);
    EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(DiscreteDistribution, EmptyOnesSaySo) {
    EXPECT_TRUE(DiscreteDistribution().empty());
    EXPECT_EQ(DiscreteDistribution().size(), 0u);
    const std::vector<double> zeros = {0, 0, 0}, one = {1e-300};
    EXPECT_TRUE(DiscreteDistribution(zeros).empty());
    EXPECT_EQ(DiscreteDistribution(zeros).size(), 3u);
    const DiscreteDistribution single(one);
    EXPECT_FALSE(single.empty());
    float u = kOneMinusEpsilon;
    EXPECT_EQ(single.sample(u), 0u);
    EXPECT_FLOAT_EQ(u, kOneMinusEpsilon);
}

TEST(DiscreteDistribution, WhatIsNoWeightIsRefused) {
    for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
        const std::vector<double> weights = {1, bad, 2};
        EXPECT_THROW(DiscreteDistribution{weights}, Error);
        const std::vector<float> values = {1, static_cast<float>(bad)};
        EXPECT_THROW(Distribution2D(values, 2, 1), Error);
    }
}

std::vector<float> sparseImage(int width, int height, uint64_t seed, float zeros = 0.4f) {
    CounterRng rng(seed);
    std::vector<float> values(size_t(width) * height);
    for (float& v : values) v = rng.next1D() < zeros ? 0.0f : std::exp(4 * rng.next1D());
    return values;
}

TEST(Distribution2D, SamplesFollowTheDensity) {
    constexpr int kWidth = 9, kHeight = 5, kSamples = 300000, kSub = 2;
    std::vector<float> values = sparseImage(kWidth, kHeight, 21);
    std::fill(values.begin() + kWidth, values.begin() + 2 * kWidth, 0.0f);  // an empty row
    const Distribution2D d(values, kWidth, kHeight);
    std::vector<double> observed(size_t(kWidth) * kHeight * kSub * kSub), expected(observed.size());
    CounterRng rng(22);
    const auto cellOf = [&](const Vec2f& p) {
        return static_cast<size_t>(p.y * kHeight * kSub) * kWidth * kSub +
               static_cast<size_t>(p.x * kWidth * kSub);
    };
    for (int i = 0; i < kSamples; ++i) {
        float pdf = 0;
        const Vec2f p = d.sample(rng.next2D(), pdf);
        ASSERT_GT(pdf, 0);
        ASSERT_NEAR(pdf, d.pdf(p), 1e-4f * pdf);
        observed[cellOf(p)] += 1;
    }
    double mass = 0;
    for (int y = 0; y < kHeight * kSub; ++y)
        for (int x = 0; x < kWidth * kSub; ++x) {
            const Vec2f p((x + 0.5f) / (kWidth * kSub), (y + 0.5f) / (kHeight * kSub));
            const double share = d.pdf(p) / double(observed.size());
            expected[cellOf(p)] = share * kSamples;
            mass += share;
        }
    EXPECT_NEAR(mass, 1, 1e-5);
    EXPECT_GT(chiSquarePValue(observed, expected), kLevel);
}

TEST(Distribution2D, ThePdfOfASampleIsThePdfOfItsPoint) {
    // Wide tables: the sum of a column and a fraction of it is rounded in single precision, and may not end
    // up in the next column, whose density is another one.
    for (const auto& [width, height] :
         {std::pair(1, 1), std::pair(3, 2), std::pair(4096, 4), std::pair(2, 2048)}) {
        const std::vector<float> values = sparseImage(width, height, 31, 0.5f);
        const Distribution2D d(values, width, height);
        if (d.empty()) continue;
        CounterRng rng(32);
        const float edges[] = {0, 0x1p-24f, 0.25f, 0.5f, 0.75f, kOneMinusEpsilon};
        for (int i = 0; i < 400000; ++i) {
            Vec2f u = rng.next2D();
            if (i < 36) u = {edges[i % 6], edges[i / 6]};
            float pdf = 0;
            const Vec2f p = d.sample(u, pdf);
            ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1) << p.x << " " << p.y;
            ASSERT_GT(pdf, 0) << u.x << " " << u.y;
            ASSERT_NEAR(d.pdf(p), pdf, 1e-5f * pdf) << width << "x" << height << " u " << u.x << " " << u.y;
        }
    }
}

TEST(Distribution2D, TotalIsTheMean) {
    const std::vector<float> values = {1, 2, 3, 6};
    const Distribution2D d(values, 2, 2);
    EXPECT_DOUBLE_EQ(d.total(), 3);
    EXPECT_FLOAT_EQ(d.pdf({0.1f, 0.1f}), 1 / 3.0f);
    EXPECT_FLOAT_EQ(d.pdf({0.9f, 0.9f}), 2);
    const std::vector<float> zeros = {0, 0};
    EXPECT_TRUE(Distribution2D(zeros, 2, 1).empty());
    EXPECT_TRUE(Distribution2D().empty());
}

}  // namespace
}  // namespace metrolux::core
