#pragma once
/// p-values for tests of distributions. Tests compare them with kLevel: with fixed seeds a correct program
/// either passes for ever or not, and of 1000 such comparisons fewer than one in a thousand sets of seeds
/// would hold a false alarm.

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>

#include <cmath>
#include <span>
#include <vector>

namespace metrolux::core::test {

inline constexpr double kLevel = 1e-6;

/// Pearson's chi-square test of counts against expected counts (same total). Cells that expect fewer than 5
/// are pooled. A count where nothing is expected gives 0.
inline double chiSquarePValue(std::span<const double> observed, std::span<const double> expected) {
    double statistic = 0, pooledObserved = 0, pooledExpected = 0;
    int cells = 0;
    for (size_t i = 0; i < observed.size(); ++i) {
        if (expected[i] <= 0 && observed[i] > 0) return 0;
        if (expected[i] < 5) {
            pooledObserved += observed[i];
            pooledExpected += expected[i];
            continue;
        }
        statistic += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
        ++cells;
    }
    if (pooledExpected > 1e-9) {
        statistic += (pooledObserved - pooledExpected) * (pooledObserved - pooledExpected) / pooledExpected;
        ++cells;
    }
    if (cells < 2) return 1;
    return boost::math::cdf(boost::math::complement(boost::math::chi_squared(cells - 1), statistic));
}

/// Against equal probabilities.
inline double chiSquarePValue(std::span<const double> observed) {
    double total = 0;
    for (const double o : observed) total += o;
    return chiSquarePValue(observed, std::vector<double>(observed.size(), total / double(observed.size())));
}

/// Two-sided p-value of a standard normal deviate.
inline double normalPValue(double z) {
    if (!std::isfinite(z)) return 0;
    return 2 * boost::math::cdf(boost::math::complement(boost::math::normal(), std::abs(z)));
}

}  // namespace metrolux::core::test
