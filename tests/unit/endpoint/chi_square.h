#pragma once
/// A chi-square test of samples in the unit square against a density there. Tests choose the map from what
/// they sample (directions, points) to the square, so that the density is smooth or constant within its bins.
///
/// Error rate: one program-wide budget. At the Sidak level 1 - (1 - kTotalErrorRate)^(1 / kMaxTests), a
/// correct program of at most kMaxTests tests fails with a probability below kTotalErrorRate. Seeds are
/// fixed.

#include "base/math.h"
#include "base/rng.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <gtest/gtest.h>

#include <functional>
#include <optional>
#include <vector>

namespace metrolux::core::test {

inline constexpr double kTotalErrorRate = 1e-3;
inline constexpr int kMaxTests = 200;

struct ChiSquareOptions {
    int samples = 100000;
    int width = 16, height = 16;  ///< bins
    int quadrature = 8;           ///< midpoints per axis and bin
};

/// `sample` gives a point, or nothing where the sampler gives nothing; `density` is per area of the unit
/// square, and zero where samples are not returned.
inline void chiSquare(const std::function<std::optional<Vec2f>(CounterRng&)>& sample,
                      const std::function<double(const Vec2f&)>& density, uint64_t seed,
                      const ChiSquareOptions& o = {}) {
    static int testsRun = 0;
    ASSERT_LE(++testsRun, kMaxTests) << "raise kMaxTests: the stated error rate no longer holds";
    const size_t bins = static_cast<size_t>(o.width) * static_cast<size_t>(o.height);
    std::vector<double> observed(bins + 1, 0.0), expected(bins + 1, 0.0);  // the last: nothing
    CounterRng rng(hashKey(seed, 77));
    for (int i = 0; i < o.samples; ++i) {
        const std::optional<Vec2f> p = sample(rng);
        if (!p) {
            ++observed[bins];
            continue;
        }
        ASSERT_TRUE(p->x > -1e-4f && p->x < 1 + 1e-4f && p->y > -1e-4f && p->y < 1 + 1e-4f)
            << p->x << " " << p->y;
        const int x = std::clamp(static_cast<int>(p->x * static_cast<float>(o.width)), 0, o.width - 1);
        const int y = std::clamp(static_cast<int>(p->y * static_cast<float>(o.height)), 0, o.height - 1);
        ++observed[static_cast<size_t>(y * o.width + x)];
    }
    double mass = 0;
    for (int y = 0; y < o.height; ++y)
        for (int x = 0; x < o.width; ++x) {
            double sum = 0;
            for (int j = 0; j < o.quadrature; ++j)
                for (int i = 0; i < o.quadrature; ++i)
                    sum += density(
                        {(static_cast<float>(x) + (static_cast<float>(i) + 0.5f) / o.quadrature) / o.width,
                         (static_cast<float>(y) + (static_cast<float>(j) + 0.5f) / o.quadrature) / o.height});
            const double p = sum / (double(o.quadrature) * o.quadrature * double(bins));
            expected[static_cast<size_t>(y * o.width + x)] = p;
            mass += p;
        }
    EXPECT_LE(mass, 1 + 2e-3) << "the density integrates to more than one";
    expected[bins] = std::max(0.0, 1 - mass);

    double statistic = 0, pooledObserved = 0, pooledExpected = 0;
    int cells = 0;
    for (size_t i = 0; i <= bins; ++i) {
        const double e = expected[i] * o.samples;
        if (e < 5) {
            pooledObserved += observed[i];
            pooledExpected += e;
            continue;
        }
        statistic += sqr(observed[i] - e) / e;
        ++cells;
    }
    if (pooledExpected >= 5) {
        statistic += sqr(pooledObserved - pooledExpected) / pooledExpected;
        ++cells;
    } else {
        EXPECT_LE(pooledObserved, pooledExpected + 30) << "samples where the density is (almost) zero";
    }
    ASSERT_GE(cells, 2);
    const double level = 1 - std::pow(1 - kTotalErrorRate, 1.0 / kMaxTests);
    const double limit = boost::math::quantile(
        boost::math::complement(boost::math::chi_squared_distribution<double>(cells - 1), level));
    EXPECT_LE(statistic, limit) << "chi-square with " << cells - 1 << " degrees of freedom; mass " << mass;
}

/// Relative closeness, with `scale` added to the magnitude.
inline void expectClose(double a, double b, double tolerance, const char* what, double scale = 1e-6) {
    EXPECT_LE(std::abs(a - b), tolerance * (std::max(std::abs(a), std::abs(b)) + scale))
        << what << ": " << a << " against " << b;
}
inline void expectClose(const Rgb& a, const Rgb& b, double tolerance, const char* what) {
    for (int k = 0; k < 3; ++k) expectClose(double(a[k]), double(b[k]), tolerance, what);
}

/// Mean and standard error of a scalar.
struct Mean {
    double sum = 0, squares = 0;
    int n = 0;
    void add(double x) {
        sum += x;
        squares += x * x;
        ++n;
    }
    double value() const { return sum / n; }
    double error() const { return std::sqrt(std::max(0.0, squares / n - sqr(value())) / n); }
};

/// Five standard errors (a correct program fails with a probability of 6e-7) and rounding.
inline void expectMean(const Mean& mean, double expected, const char* what) {
    EXPECT_NEAR(mean.value(), expected, 5 * mean.error() + 1e-3 * std::abs(expected)) << what;
}

}  // namespace metrolux::core::test
