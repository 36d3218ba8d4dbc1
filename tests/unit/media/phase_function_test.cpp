#include "media/phase_function.h"

#include "base/error.h"
#include "base/rng.h"
#include "media/grid_volume.h"
#include "support/goodness_of_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

const Vec3f kPlace(0.25f, 0.5f, 0.5f);

struct PhaseCase {
    std::string name;
    PhaseFunctionPtr phase;
    double meanCosine;  ///< NaN: not known
};

std::vector<PhaseCase> phaseCases() {
    std::vector<PhaseCase> cases{{"isotropic", makeIsotropicPhase(), 0},
                                 {"rayleigh", makeRayleighPhase(), 0}};
    for (const float g : {-0.99f, -0.5f, -0.0009f, 0.0f, 0.0008f, 0.0011f, 0.3f, 0.9f, 0.99f})
        cases.push_back({fmt::format("hg {}", g), makeHenyeyGreensteinPhase(g), double(g)});
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    // A ramp: (1 + cosine) / 2 over the cosine has the mean 1/3.
    cases.push_back({"ramp", makeTabulatedPhase(std::vector<float>{0, 3}), 1.0 / 3});
    cases.push_back({"ramp down", makeTabulatedPhase(std::vector<float>{7, 0}), -1.0 / 3});
    cases.push_back({"flat", makeTabulatedPhase(std::vector<float>{2, 2, 2}), 0});
    cases.push_back({"table", makeTabulatedPhase(std::vector<float>{0.2f, 0, 0, 1, 0.5f, 0.5f, 4}), unknown});
    GridSamples weights;
    weights.resolution = {2, 1, 1};
    weights.values = {0.25f, 1};
    const VolumePtr weight = makeGridVolume(weights, {.filter = GridFilter::Nearest});
    cases.push_back(
        {"blend", makeBlendPhase(makeHenyeyGreensteinPhase(0.8f), makeHenyeyGreensteinPhase(-0.4f), weight),
         0.75 * 0.8 - 0.25 * 0.4});
    cases.push_back({"blend of a blend",
                     makeBlendPhase(cases.back().phase, makeRayleighPhase(), makeConstantVolume(Rgb(0.5f))),
                     0.5 * (0.75 * 0.8 - 0.25 * 0.4)});
    return cases;
}

/// Integral of f(cosine) over the sphere, on steps that are small at both ends.
double overSphere(
    const PhaseFunction& phase, double from, double to,
    const std::function<double(double)>& f = [](double) { return 1.0; }) {
    constexpr int kSteps = 20000;
    // cosine = sin(angle): the steps shrink towards -1 and 1.
    const double a = std::asin(from), b = std::asin(to);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double angle = a + (b - a) * (i + 0.5) / kSteps, cosine = std::sin(angle);
        sum += double(phase.evaluate(kPlace, float(cosine))) * f(cosine) * std::cos(angle) * (b - a) / kSteps;
    }
    return 2 * std::numbers::pi * sum;
}

TEST(PhaseFunction, IntegratesToOne) {
    for (const PhaseCase& c : phaseCases()) EXPECT_NEAR(overSphere(*c.phase, -1, 1), 1, 2e-4) << c.name;
}

TEST(PhaseFunction, MeanCosine) {
    for (const PhaseCase& c : phaseCases()) {
        if (std::isnan(c.meanCosine)) continue;
        const auto cosine = [](double x) { return x; };
        EXPECT_NEAR(overSphere(*c.phase, -1, 1, cosine), c.meanCosine, 2e-4) << c.name;
        CounterRng rng(11);
        double sum = 0, squares = 0;
        constexpr int kSamples = 40000;
        for (int i = 0; i < kSamples; ++i) {
            const float uLobe = rng.next1D(), u = rng.next1D();
            const double x = double(c.phase->sample(kPlace, uLobe, u).cosine);
            sum += x;
            squares += x * x;
        }
        const double mean = sum / kSamples, error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
        EXPECT_NEAR(mean, c.meanCosine, 5 * error + 1e-6) << c.name;
    }
}

TEST(PhaseFunction, RayleighHasItsSecondMoment) {
    EXPECT_NEAR(overSphere(*makeRayleighPhase(), -1, 1, [](double x) { return x * x; }), 0.4, 1e-5);
    EXPECT_FLOAT_EQ(makeRayleighPhase()->evaluate(kPlace, 1), 6 / (16 * kPi));
}

TEST(PhaseFunction, SamplesFollowTheDensity) {
    for (const PhaseCase& c : phaseCases()) {
        constexpr int kBins = 64, kSamples = 100000;
        std::vector<double> observed(kBins, 0.0), expected(kBins, 0.0);
        CounterRng rng(12);
        for (int i = 0; i < kSamples; ++i) {
            const float uLobe = rng.next1D(), u = rng.next1D();
            const auto sample = c.phase->sample(kPlace, uLobe, u);
            ASSERT_TRUE(sample.cosine >= -1 && sample.cosine <= 1) << c.name;
            ASSERT_FLOAT_EQ(sample.density, c.phase->evaluate(kPlace, sample.cosine)) << c.name;
            ++observed[size_t(std::min(int((sample.cosine + 1) * 0.5f * kBins), kBins - 1))];
        }
        for (int i = 0; i < kBins; ++i)
            expected[size_t(i)] =
                kSamples * overSphere(*c.phase, -1 + 2.0 * i / kBins, -1 + 2.0 * (i + 1) / kBins);
        EXPECT_GT(test::chiSquarePValue(observed, expected), test::kLevel) << c.name;
    }
}

TEST(PhaseFunction, EndsOfTheIntervalAreSampled) {
    for (const PhaseCase& c : phaseCases())
        for (const float uLobe : {0.0f, 0.2f, kOneMinusEpsilon})
            for (const float u : {0.0f, kOneMinusEpsilon}) {
                const auto sample = c.phase->sample(kPlace, uLobe, u);
                EXPECT_TRUE(std::isfinite(sample.density) && std::abs(sample.cosine) <= 1) << c.name;
            }
}

TEST(PhaseFunction, SharpPeaksStayFinite) {
    for (const float g : {0.9999f, -0.9999f, 0.999999f}) {
        const PhaseFunctionPtr phase = makeHenyeyGreensteinPhase(g);
        const float peak = phase->evaluate(kPlace, std::copysign(1.0f, g));
        const double h = 1 - std::abs(double(g));
        EXPECT_NEAR(double(peak) / ((1 + std::abs(double(g))) / (4 * std::numbers::pi * h * h)), 1, 1e-5)
            << g;
    }
}

TEST(PhaseFunction, TableIsLinearBetweenItsValues) {
    const PhaseFunctionPtr phase = makeTabulatedPhase(std::vector<float>{1, 3, 0});
    // Its integral over the cosine is 2 + 1.5.
    const auto expect = [&](float cosine, double value) {
        EXPECT_NEAR(double(phase->evaluate(kPlace, cosine)), value / 3.5 / (2 * std::numbers::pi), 1e-7);
    };
    expect(-1, 1);
    expect(-0.5f, 2);
    expect(0, 3);
    expect(0.25f, 2.25);
    expect(1, 0);
}

TEST(PhaseFunction, BlendTakesTheWeightOfThePlace) {
    GridSamples weights;
    weights.resolution = {2, 1, 1};
    weights.values = {0, 1};
    const PhaseFunctionPtr first = makeIsotropicPhase(), second = makeHenyeyGreensteinPhase(0.7f);
    const PhaseFunctionPtr blend =
        makeBlendPhase(first, second, makeGridVolume(weights, {.filter = GridFilter::Nearest}));
    EXPECT_EQ(blend->evaluate({0.2f, 0, 0}, 0.9f), first->evaluate(kPlace, 0.9f));
    EXPECT_EQ(blend->evaluate({0.8f, 0, 0}, 0.9f), second->evaluate(kPlace, 0.9f));
    EXPECT_EQ(blend->sample({0.2f, 0, 0}, 0, 0.3f).cosine, first->sample(kPlace, 0, 0.3f).cosine);
    EXPECT_EQ(blend->sample({0.8f, 0, 0}, kOneMinusEpsilon, 0.3f).cosine,
              second->sample(kPlace, 0, 0.3f).cosine);
}

TEST(PhaseFunction, RefusesBadNumbers) {
    const auto messageOf = [](const std::function<void()>& make) -> std::string {
        try {
            make();
        } catch (const Error& error) {
            return error.what();
        }
        return "none";
    };
    const auto table = [&](std::vector<float> values) {
        return messageOf([&] { makeTabulatedPhase(values); });
    };
    EXPECT_THAT(table({1}), testing::HasSubstr("found 1 values, expected two"));
    EXPECT_THAT(table({1, -2}), testing::HasSubstr("value 1 (counted from 0) is -2"));
    EXPECT_THAT(table({std::numeric_limits<float>::quiet_NaN(), 1}), testing::HasSubstr("value 0"));
    EXPECT_THAT(table({0, 0, 0}), testing::HasSubstr("all values are 0"));
    EXPECT_THAT(messageOf([] { makeHenyeyGreensteinPhase(1); }), testing::HasSubstr("(-1, 1)"));
    EXPECT_THAT(messageOf([] {
                    makeBlendPhase(makeIsotropicPhase(), makeRayleighPhase(), makeConstantVolume(Rgb(1.5f)));
                }),
                testing::HasSubstr("weight of 1.5"));
}

}  // namespace
}  // namespace metrolux::core
