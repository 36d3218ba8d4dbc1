#include "study/curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace metrolux::core::study {
namespace {

using testing::ElementsAre;

Measurement measurement(uint32_t passes, double seconds, double error, double bias = 0) {
    Measurement m{passes, seconds, {}};
    m.values.fill(error);
    m.values[indexOf(Metric::Bias)] = bias;
    return m;
}

/// A run whose error is factor / seconds, a pass a second.
std::vector<Measurement> run(double factor, uint32_t passes) {
    std::vector<Measurement> result;
    for (uint32_t i = 1; i <= passes; ++i) result.push_back(measurement(i, i, factor / i, factor));
    return result;
}

TEST(MeasuringGrid, IsGeometricAndEndsAtTheLimit) {
    const std::vector<double> times = measuringGrid(Abscissa::Seconds, 60);
    EXPECT_DOUBLE_EQ(times.back(), 60);
    EXPECT_LT(times.front(), 0.01);
    for (size_t i = 1; i < times.size(); ++i) EXPECT_NEAR(times[i] / times[i - 1], kGridRatio, 1e-12);
    EXPECT_THAT(measuringGrid(Abscissa::Passes, 16), ElementsAre(1, 2, 3, 4, 6, 8, 11, 16));
    EXPECT_THAT(measuringGrid(Abscissa::Passes, 1), ElementsAre(1));
}

TEST(MeasuringSchedule, MeasuresTheFirstPassAndThoseThatPassTheGrid) {
    MeasuringSchedule schedule({1, 2, 4, 8});
    std::vector<double> measured;
    for (double t : {0.3, 0.6, 1.0, 1.5, 5.0, 6.0, 9.0, 10.0})
        if (schedule.due(t)) measured.push_back(t);
    EXPECT_THAT(measured, ElementsAre(0.3, 1.0, 5.0, 9.0));
}

TEST(Summarize, MeansOverSeedsAreGeometricForErrorsAndArithmeticForTheBias) {
    const auto curve = summarize({run(1, 8), run(4, 8)}, Abscissa::Passes, {1, 2, 4, 8});
    ASSERT_EQ(curve.size(), 4u);
    EXPECT_DOUBLE_EQ(curve[1].passes, 2);
    for (Metric metric : {Metric::RelMse, Metric::TrimmedRelMse, Metric::Mse, Metric::Smape})
        EXPECT_NEAR(curve[1].values[indexOf(metric)].mean, 2.0 / 2, 1e-12);
    EXPECT_NEAR(curve[1].values[indexOf(Metric::Bias)].mean, 2.5, 1e-12);
    EXPECT_NEAR(curve.back().values[0].mean, 2.0 / 8, 1e-12);
}

TEST(Summarize, InterpolatesPowerLawsExactlyAndDoesNotExtrapolate) {
    const std::vector<Measurement> sparse{measurement(1, 1, 5), measurement(16, 16, 5.0 / 16)};
    const auto curve = summarize({sparse}, Abscissa::Seconds, {0.5, 3, 7, 32});
    ASSERT_EQ(curve.size(), 4u) << "first, 3, 7, last";
    EXPECT_DOUBLE_EQ(curve[0].seconds, 1);
    EXPECT_NEAR(curve[1].values[0].mean, 5.0 / 3, 1e-12);
    EXPECT_NEAR(curve[2].values[0].mean, 5.0 / 7, 1e-12);
    EXPECT_NEAR(curve[2].passes, 7, 1e-12);
    EXPECT_DOUBLE_EQ(curve[3].seconds, 16);
}

TEST(Summarize, LeavesOutWhatNotAllRunsSpan) {
    const auto curve = summarize({run(1, 8), {}, run(1, 4)}, Abscissa::Passes, {1, 2, 3, 4, 6, 8});
    ASSERT_EQ(curve.size(), 4u);
    EXPECT_NEAR(curve.back().passes, std::sqrt(32.0), 1e-12) << "the last measurements of both";
    EXPECT_TRUE(summarize({{}, {}}, Abscissa::Passes, {1, 2}).empty());
}

TEST(Summarize, OneMeasurementIsOnePoint) {
    const auto curve = summarize({run(1, 1), run(1, 1)}, Abscissa::Passes, {1});
    ASSERT_EQ(curve.size(), 1u);
}

TEST(FitRun, TakesTheLastFourDoublings) {
    std::vector<Measurement> points;
    // A start that does not converge, then 1/t.
    for (double t = 1; t <= 1024; t *= 2) points.push_back(measurement(1, t, t < 64 ? 1 : 64 / t));
    const PowerLaw fit = fitRun(points, Metric::Mse);
    EXPECT_NEAR(fit.slope, -1, 1e-12);
    EXPECT_EQ(fit.points, 5u);
    EXPECT_EQ(fitRun(points, Metric::Bias).points, 0u);
    EXPECT_EQ(fitRun({points[9], points[10]}, Metric::Mse).points, 0u) << "two points say nothing of a rate";
}

}  // namespace
}  // namespace metrolux::core::study
