#pragma once
/// Error over time: when to measure, and what several seeds say together.

#include "study/metric.h"
#include "study/statistics.h"

#include <cstdint>

namespace metrolux::core::study {

/// What one run has reached at one time.
struct Measurement {
    uint32_t passes = 0;
    double seconds = 0;  ///< of rendering, the integrator's construction included, measuring excluded
    PerMetric<double> values{};
};

/// What an equal-time study compares at, or an equal-pass one.
enum class Abscissa { Seconds, Passes };

inline double positionOf(const Measurement& m, Abscissa abscissa) {
    return abscissa == Abscissa::Seconds ? m.seconds : m.passes;
}

inline constexpr double kGridRatio = 1.4142135623730951;  ///< of neighboring measuring times

/// last, last/r, last/r^2 ... in ascending order, r = kGridRatio: 28 steps for times, down to 1 for passes
/// (whole numbers, each once).
std::vector<double> measuringGrid(Abscissa abscissa, double last);

/// Says when a run is to be measured: after the first pass, and after the first pass at or beyond each
/// position of the grid.
class MeasuringSchedule {
  public:
    explicit MeasuringSchedule(std::vector<double> grid) : grid_(std::move(grid)) {}
    /// To be asked once after each pass.
    bool due(double position);

  private:
    std::vector<double> grid_;
    size_t next_ = 0;
    bool first_ = true;
};

/// Means over seeds at one position.
struct CurvePoint {
    double passes = 0, seconds = 0;  ///< geometric means over the seeds
    PerMetric<Interval> values{};    ///< geometric means of errors, arithmetic ones of the bias
};

/// The curve of several runs: their first measurements, the positions of the grid that all of them span
/// (interpolated on logarithmic scales, the bias and where an error is zero on a linear one), their last
/// measurements. Runs without measurements are left out.
std::vector<CurvePoint> summarize(const std::vector<std::vector<Measurement>>& runs, Abscissa abscissa,
                                  const std::vector<double>& grid);

inline constexpr double kFitShare =
    1.0 / 16;  ///< a rate is fitted to the times from this share of the last one on
inline constexpr size_t kFewestFitPoints = 3;

/// Error against seconds by a power law, from the measurements from kFitShare of the last time on; no fit for
/// fewer than kFewestFitPoints, nor for the bias, which changes its sign.
PowerLaw fitRun(const std::vector<Measurement>& run, Metric metric);

}  // namespace metrolux::core::study
