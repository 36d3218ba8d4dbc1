#include "study/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace metrolux::core::study {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Intervals, AreThoseOfStudentsT) {
    // Mean 2, standard deviation 1, standard error 1/sqrt(3); the 97.5 % quantile of t with 2 degrees of
    // freedom.
    const Interval interval = meanInterval({1, 2, 3});
    EXPECT_DOUBLE_EQ(interval.mean, 2);
    EXPECT_NEAR(interval.high - 2, 4.302652729911275 / std::sqrt(3.0), 1e-9);
    EXPECT_NEAR(2 - interval.low, 4.302652729911275 / std::sqrt(3.0), 1e-9);
}

TEST(Intervals, OfErrorsAreSymmetricOnALogarithmicScale) {
    const Interval interval = geometricInterval({0.01, 0.1, 1});
    EXPECT_NEAR(interval.mean, 0.1, 1e-12);
    EXPECT_NEAR(interval.high / interval.mean, interval.mean / interval.low, 1e-9);
    EXPECT_NEAR(std::log(interval.high / interval.mean), 4.302652729911275 / std::sqrt(3.0) * std::log(10),
                1e-9);
}

TEST(Intervals, OfOneValueOrOfZeroHaveNoEnds) {
    for (const Interval& interval : {meanInterval({5}), geometricInterval({5})}) {
        EXPECT_NEAR(interval.mean, 5, 1e-12);
        EXPECT_TRUE(std::isnan(interval.low) && std::isnan(interval.high));
    }
    const Interval zero = geometricInterval({0, 2});
    EXPECT_DOUBLE_EQ(zero.mean, 1);
    EXPECT_TRUE(std::isnan(zero.low));
}

TEST(Intervals, CoverTheMeanAsOftenAsTheySay) {
    std::mt19937_64 generator(1);
    std::normal_distribution<double> normal(3, 2);
    constexpr int kTrials = 20000;
    int covered = 0;
    for (int i = 0; i < kTrials; ++i) {
        const Interval interval = meanInterval({normal(generator), normal(generator), normal(generator)});
        covered += interval.low <= 3 && 3 <= interval.high;
    }
    // Four standard deviations of a binomial distribution: one failure in 16000 seeds.
    EXPECT_NEAR(covered, kConfidence * kTrials, 4 * std::sqrt(kTrials * kConfidence * (1 - kConfidence)));
}

TEST(PowerLaw, IsRecoveredExactly) {
    for (double slope : {-1.0, -0.5, 0.0, 2.0}) {
        std::vector<std::pair<double, double>> points;
        for (double x = 0.1; x < 100; x *= 1.7) points.emplace_back(x, 3 * std::pow(x, slope));
        const PowerLaw fit = fitPowerLaw(points);
        EXPECT_NEAR(fit.slope, slope, 1e-12);
        EXPECT_NEAR(std::exp(fit.logFactor), 3, 1e-11);
        EXPECT_NEAR(fit.standardError, 0, 1e-12);
        EXPECT_EQ(fit.points, points.size());
    }
}

TEST(PowerLaw, StandardErrorIsTheScatterOfTheSlope) {
    std::mt19937_64 generator(2);
    std::normal_distribution<double> noise(0, 0.3);
    constexpr int kTrials = 4000;
    double squares = 0, stated = 0;
    for (int i = 0; i < kTrials; ++i) {
        std::vector<std::pair<double, double>> points;
        for (int k = 0; k < 9; ++k)
            points.emplace_back(std::exp2(k), std::pow(std::exp2(k), -1) * std::exp(noise(generator)));
        const PowerLaw fit = fitPowerLaw(points);
        squares += (fit.slope + 1) * (fit.slope + 1) / kTrials;
        stated += fit.standardError * fit.standardError / kTrials;
    }
    EXPECT_NEAR(stated / squares, 1, 0.1);
}

TEST(PowerLaw, NeedsTwoUsablePoints) {
    EXPECT_EQ(fitPowerLaw({}).points, 0u);
    EXPECT_EQ(fitPowerLaw({{1, 2}}).points, 0u);
    EXPECT_EQ(fitPowerLaw({{1, 2}, {1, 3}}).points, 0u);
    EXPECT_EQ(fitPowerLaw({{1, 2}, {2, 0}}).points, 0u) << "an error of zero has no logarithm";
    EXPECT_TRUE(std::isnan(fitPowerLaw({{1, 2}}).slope));
    const PowerLaw two = fitPowerLaw({{1, 4}, {2, 1}});
    EXPECT_NEAR(two.slope, -2, 1e-12);
    EXPECT_TRUE(std::isnan(two.standardError));
}

TEST(ConvergenceRate, IsTheMeanOverSeedsWithItsStandardError) {
    PowerLaw a, b, none;
    a.slope = -0.9;
    b.slope = -1.1;
    a.points = b.points = 5;
    const Rate rate = convergenceRate({a, none, b});
    EXPECT_DOUBLE_EQ(rate.slope, -1);
    EXPECT_NEAR(rate.standardError, 0.1, 1e-12);
    EXPECT_EQ(rate.seeds, 2u);
    EXPECT_EQ(convergenceRate({none}).seeds, 0u);
    EXPECT_TRUE(std::isnan(convergenceRate({a}).standardError));
}

TEST(Welch, GivesTheTextbookPValue) {
    // Welch's t = 1/sqrt(2/3), four degrees of freedom.
    EXPECT_NEAR(welchPValue({1, 2, 3}, {2, 3, 4}), 0.28786413472669, 1e-9);
    EXPECT_EQ(welchPValue({1, 1}, {1, 1}), 1);
    EXPECT_EQ(welchPValue({1, 1}, {2, 2}), 0);
    EXPECT_TRUE(std::isnan(welchPValue({1}, {2, 3})));
}

TEST(Ranking, TellsTheWinnerAndWhoCannotBeToldFromIt) {
    const Ranking ranking = rankSmallest({{5.0, 5.1, 5.2}, {1.0, 1.1, 1.2}, {}, {1.05, 1.15, 1.25}});
    EXPECT_EQ(ranking.winner, 1u);
    EXPECT_THAT(ranking.tied, ElementsAre(3u));
    const Ranking single = rankSmallest({{2}, {1}});
    EXPECT_EQ(single.winner, 1u);
    EXPECT_THAT(single.tied, IsEmpty()) << "one value says nothing of noise";
    EXPECT_EQ(rankSmallest({{}, {}}).winner, Ranking::kNone);
}

}  // namespace
}  // namespace metrolux::core::study
