#include "image/filter.h"

#include "base/error.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using Kind = ReconstructionFilter::Kind;

struct Case {
    const char* name;
    Kind kind;
    ReconstructionFilter::Parameters parameters;
};

std::vector<Case> cases() {
    ReconstructionFilter::Parameters narrow, wide, oddRadius, manyLobes;
    narrow.stddev = 0.2f;
    wide.stddev = 1.5f;
    oddRadius.radius = 1.37f;
    manyLobes.lobes = 4;
    return {{"box", Kind::Box, {}},
            {"tent", Kind::Tent, {}},
            {"gaussian", Kind::Gaussian, {}},
            {"narrow gaussian", Kind::Gaussian, narrow},
            {"wide gaussian", Kind::Gaussian, wide},
            {"box of odd radius", Kind::Box, oddRadius},
            {"mitchell", Kind::Mitchell, {}},
            {"mitchell of odd radius", Kind::Mitchell, oddRadius},
            {"catmullrom", Kind::CatmullRom, {}},
            {"lanczos", Kind::Lanczos, {}},
            {"lanczos of four lobes", Kind::Lanczos, manyLobes}};
}

constexpr int kSizes[] = {1, 2, 3, 20};

TEST(Filter, DefaultRadii) {
    EXPECT_FLOAT_EQ(ReconstructionFilter(Kind::Box, {}).radius(), 0.5f);
    EXPECT_FLOAT_EQ(ReconstructionFilter(Kind::Tent, {}).radius(), 1);
    EXPECT_FLOAT_EQ(ReconstructionFilter(Kind::Gaussian, {}).radius(), 2);
    EXPECT_FLOAT_EQ(ReconstructionFilter(Kind::Mitchell, {}).radius(), 2);
    EXPECT_FLOAT_EQ(ReconstructionFilter(Kind::CatmullRom, {}).radius(), 2);
    EXPECT_FLOAT_EQ(ReconstructionFilter(Kind::Lanczos, {}).radius(), 3);
}

TEST(Filter, RefusesWhatItCannotTabulate) {
    ReconstructionFilter::Parameters parameters;
    parameters.radius = -1;
    EXPECT_THROW(ReconstructionFilter(Kind::Box, parameters), Error);
    parameters.radius = 1e9f;
    EXPECT_THROW(ReconstructionFilter(Kind::Box, parameters), Error);
    parameters.radius = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(ReconstructionFilter(Kind::Tent, parameters), Error);
    parameters = {};
    parameters.stddev = 0;
    EXPECT_THROW(ReconstructionFilter(Kind::Gaussian, parameters), Error);
    parameters = {};
    parameters.lobes = 0;
    EXPECT_THROW(ReconstructionFilter(Kind::Lanczos, parameters), Error);
}

TEST(Filter, KnownShapes) {
    // Values relative to the center, from the definitions.
    const auto ratio = [](Kind kind, float x) {
        const ReconstructionFilter filter(kind, {});
        return filter.evaluate(50, 101, 50.5f + x) / filter.evaluate(50, 101, 50.5f);
    };
    const double g0 = 1 - std::exp(-8.0);
    EXPECT_NEAR(ratio(Kind::Gaussian, 0.5f), (std::exp(-0.5) - std::exp(-8.0)) / g0, 5e-3);
    EXPECT_NEAR(ratio(Kind::Gaussian, 1.0f), (std::exp(-2.0) - std::exp(-8.0)) / g0, 5e-3);
    EXPECT_NEAR(ratio(Kind::Tent, 0.25f), 0.75, 5e-3);
    EXPECT_NEAR(ratio(Kind::Mitchell, 1.0f), (1.0 / 18) / (8.0 / 9), 5e-3);
    EXPECT_NEAR(ratio(Kind::CatmullRom, 1.0f), 0, 5e-3);
    EXPECT_LT(ratio(Kind::CatmullRom, 1.5f), -0.05);
    EXPECT_LT(ratio(Kind::Lanczos, 1.5f), -0.1);
    EXPECT_EQ(ratio(Kind::Box, 0.51f), 0);
}

/// Sum of evaluate() * g over a grid that is fine compared with the filter's cells.
template <class Function>
double quadrature(const ReconstructionFilter& filter, int pixel, int size, Function g) {
    const int steps = 4096;
    double sum = 0;
    for (int i = 0; i < size * steps; ++i) {
        const float x = (static_cast<float>(i) + 0.5f) / steps;
        sum += filter.evaluate(pixel, size, x) * g(x) / steps;
    }
    return sum;
}

TEST(Filter, IntegralIsOneForEveryPixelAlsoAtBorders) {
    for (const Case& c : cases()) {
        const ReconstructionFilter filter(c.kind, c.parameters);
        for (int size : kSizes)
            for (int pixel = 0; pixel < size; ++pixel)
                EXPECT_NEAR(quadrature(filter, pixel, size, [](float) { return 1.0; }), 1, 1e-3)
                    << c.name << ", pixel " << pixel << " of " << size;
    }
}

TEST(Filter, SamplingAgreesWithEvaluation) {
    const auto g = [](float x) { return 1.3 + std::cos(2.1 * x) + 0.2 * x; };
    for (const Case& c : cases()) {
        const ReconstructionFilter filter(c.kind, c.parameters);
        for (int size : kSizes) {
            for (int pixel = 0; pixel < size; ++pixel) {
                const int n = 20000;  // a midpoint rule in u: no noise
                double sampled = 0;
                for (int i = 0; i < n; ++i) {
                    float weight = 1;
                    const float x = filter.sample(pixel, size, (static_cast<float>(i) + 0.5f) / n, weight);
                    ASSERT_GE(x, 0);
                    ASSERT_LE(x, static_cast<float>(size));
                    sampled += weight * g(x) / n;
                }
                EXPECT_NEAR(sampled, quadrature(filter, pixel, size, g), 2e-3)
                    << c.name << ", pixel " << pixel << " of " << size;
            }
        }
    }
}

TEST(Filter, SampleMultipliesIntoTheWeight) {
    const ReconstructionFilter filter(Kind::Lanczos, {});
    float once = 1, scaled = 3;
    filter.sample(4, 9, 0.1f, once);
    filter.sample(4, 9, 0.1f, scaled);
    EXPECT_FLOAT_EQ(scaled, 3 * once);
}

TEST(Filter, ExtremeUniformNumbersStayInTheImage) {
    for (const Case& c : cases()) {
        const ReconstructionFilter filter(c.kind, c.parameters);
        for (float u : {0.0f, 1e-30f, kOneMinusEpsilon}) {
            float weight = 1;
            const float x = filter.sample(0, 5000, u, weight);
            EXPECT_GE(x, 0) << c.name;
            EXPECT_LE(std::abs(x - 0.5f), filter.radius() + 1e-3f) << c.name;
            EXPECT_TRUE(std::isfinite(weight)) << c.name;
        }
    }
}

TEST(ReconstructionFilter, SquaredWeightsAreTheSumsOverPixelsMeanOverPositions) {
    for (const auto& [name, kind] : filterNames()) {
        const ReconstructionFilter filter(kind, {});
        constexpr int kSize = 64, kSteps = 512;
        double sum = 0;
        for (int i = 0; i < kSteps; ++i)
            for (int pixel = 0; pixel < kSize; ++pixel)
                sum += sqr(double(filter.evaluate(pixel, kSize, 32 + (float(i) + 0.5f) / kSteps)));
        EXPECT_NEAR(filter.squaredWeights() / sqr(sum / kSteps), 1, 1e-3) << name;
    }
}

}  // namespace
}  // namespace metrolux::core
