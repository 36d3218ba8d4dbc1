#include "study/curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace metrolux::core::study {
namespace {

constexpr int kTimeSteps = 28;  // 2^14: from a minute down to 4 ms

/// Linear on logarithmic scales where both ends allow it.
double interpolate(double t, double a, double b) {
    if (a > 0 && b > 0) return std::exp(std::lerp(std::log(a), std::log(b), t));
    return std::lerp(a, b, t);
}

/// A measurement, or one that lies between two.
struct Sample {
    double passes = 0, seconds = 0;
    PerMetric<double> values{};
};

Sample sampleOf(const Measurement& m) { return {static_cast<double>(m.passes), m.seconds, m.values}; }

Sample interpolate(double t, const Measurement& a, const Measurement& b) {
    Sample s{interpolate(t, a.passes, b.passes), interpolate(t, a.seconds, b.seconds), {}};
    for (Metric metric : kMetrics) {
        const size_t i = indexOf(metric);
        s.values[i] = metric == Metric::Bias ? std::lerp(a.values[i], b.values[i], t)
                                             : interpolate(t, a.values[i], b.values[i]);
    }
    return s;
}

/// The same position in several runs.
class PointBuilder {
  public:
    void add(const Sample& s) {
        passes_.push_back(s.passes);
        seconds_.push_back(s.seconds);
        for (size_t i = 0; i < kMetricCount; ++i) values_[i].push_back(s.values[i]);
    }
    CurvePoint build() const {
        CurvePoint point;
        point.passes = geometricInterval(passes_).mean;
        point.seconds = geometricInterval(seconds_).mean;
        for (Metric metric : kMetrics) {
            const size_t i = indexOf(metric);
            point.values[i] =
                metric == Metric::Bias ? meanInterval(values_[i]) : geometricInterval(values_[i]);
        }
        return point;
    }

  private:
    std::vector<double> passes_, seconds_;
    PerMetric<std::vector<double>> values_;
};

/// What a run has at a position that it spans.
Sample sampleAt(const std::vector<Measurement>& run, Abscissa abscissa, double position) {
    const auto after = std::find_if(
        run.begin(), run.end(), [&](const Measurement& m) { return positionOf(m, abscissa) >= position; });
    if (after == run.begin() || positionOf(*after, abscissa) == position) return sampleOf(*after);
    const Measurement& before = *(after - 1);
    const double from = std::log(positionOf(before, abscissa)), to = std::log(positionOf(*after, abscissa));
    return interpolate((std::log(position) - from) / (to - from), before, *after);
}

}  // namespace

std::vector<double> measuringGrid(Abscissa abscissa, double last) {
    std::vector<double> grid;
    for (int step = 0;; ++step) {
        double position = last * std::pow(kGridRatio, -step);
        if (abscissa == Abscissa::Passes) position = std::round(position);
        if (abscissa == Abscissa::Passes ? position < 1 : step > kTimeSteps) break;
        if (grid.empty() || position < grid.back()) grid.push_back(position);
    }
    std::reverse(grid.begin(), grid.end());
    return grid;
}

bool MeasuringSchedule::due(double position) {
    bool passed = std::exchange(first_, false);
    while (next_ < grid_.size() && position >= grid_[next_]) {
        ++next_;
        passed = true;
    }
    return passed;
}

std::vector<CurvePoint> summarize(const std::vector<std::vector<Measurement>>& runs, Abscissa abscissa,
                                  const std::vector<double>& grid) {
    double first = 0, last = std::numeric_limits<double>::infinity();
    PointBuilder beginning, end;
    bool any = false;
    for (const auto& run : runs) {
        if (run.empty()) continue;
        any = true;
        first = std::max(first, positionOf(run.front(), abscissa));
        last = std::min(last, positionOf(run.back(), abscissa));
        beginning.add(sampleOf(run.front()));
        end.add(sampleOf(run.back()));
    }
    std::vector<CurvePoint> curve;
    if (!any) return curve;
    if (first < last) curve.push_back(beginning.build());
    for (double position : grid) {
        if (!(position > first && position < last)) continue;
        PointBuilder point;
        for (const auto& run : runs)
            if (!run.empty()) point.add(sampleAt(run, abscissa, position));
        curve.push_back(point.build());
    }
    curve.push_back(end.build());
    return curve;
}

PowerLaw fitRun(const std::vector<Measurement>& run, Metric metric) {
    std::vector<std::pair<double, double>> points;
    for (const Measurement& m : run)
        if (metric != Metric::Bias && m.seconds >= kFitShare * run.back().seconds)
            points.emplace_back(m.seconds, m.values[indexOf(metric)]);
    if (points.size() < kFewestFitPoints) points.clear();
    return fitPowerLaw(points);
}

}  // namespace metrolux::core::study
