#pragma once
/// The statistics of a study: means with confidence intervals over seeds, fitted convergence rates, tests.

#include <cstddef>
#include <utility>
#include <vector>

namespace metrolux::core::study {

inline constexpr double kConfidence = 0.95;  ///< of all intervals
inline constexpr double kSignificance = 1 - kConfidence;

/// A mean over seeds with its confidence interval of Student's t; the ends are NaN for fewer than two values.
struct Interval {
    double mean = 0, low = 0, high = 0;
};

/// Arithmetic mean, for signed quantities. Precondition: not empty.
Interval meanInterval(const std::vector<double>& values);
/// Geometric mean, for errors, whose scatter is relative: the exponential of meanInterval of the logarithms.
/// When a value is not above zero the logarithm does not exist and the ends are NaN, the mean the
/// arithmetic one. Precondition: not empty.
Interval geometricInterval(const std::vector<double>& values);

/// y = c x^slope, fitted by least squares to log y over log x.
struct PowerLaw {
    double slope = 0;
    double logFactor = 0;  ///< natural logarithm of c
    /// Standard error of the slope if the residuals were independent; NaN for two points.
    double standardError = 0;
    size_t points = 0;
};

/// Points that are not finite and above zero in both coordinates are left out; fewer than two points, or
/// points of one x, have no fit: `points` is 0 and the rest NaN.
PowerLaw fitPowerLaw(const std::vector<std::pair<double, double>>& points);

/// Convergence rate of one integrator: the mean over seeds of the slopes of their fits.
struct Rate {
    double slope = 0;
    /// From the scatter between seeds, which are independent (the points of one run are not). NaN for one
    /// seed.
    double standardError = 0;
    size_t seeds = 0;  ///< that have a fit; 0: no rate
};
Rate convergenceRate(const std::vector<PowerLaw>& fits);

/// Two-sided p-value of Welch's test that two samples have the same mean. NaN when a sample has fewer than
/// two values; 0 or 1 when neither scatters.
double welchPValue(const std::vector<double>& a, const std::vector<double>& b);

/// Which of several samples has the smallest mean.
struct Ranking {
    static constexpr size_t kNone = static_cast<size_t>(-1);
    size_t winner = kNone;
    /// Others that Welch's test does not tell from the winner at kSignificance (each on its own, without a
    /// correction for their number).
    std::vector<size_t> tied;
};

/// Empty samples do not take part.
Ranking rankSmallest(const std::vector<std::vector<double>>& samples);

}  // namespace metrolux::core::study
