#pragma once
#include "image/compare.h"

#include <array>

namespace metrolux::core::study {

/// What a study follows; defined in image/compare.h. All but Bias are above zero and smaller is better; Bias
/// is signed and is judged by its absolute value.
enum class Metric { RelMse, TrimmedRelMse, Mse, Smape, Bias };
inline constexpr size_t kMetricCount = 5;

template <class Value>
using PerMetric = std::array<Value, kMetricCount>;

inline constexpr PerMetric<Metric> kMetrics{Metric::RelMse, Metric::TrimmedRelMse, Metric::Mse, Metric::Smape,
                                            Metric::Bias};
/// Keys in study.json and curves.csv; the same as those of `metrolux compare --json`.
inline constexpr PerMetric<const char*> kMetricKeys{"rel_mse", "trimmed_rel_mse", "mse", "smape", "bias"};
inline constexpr PerMetric<const char*> kMetricTitles{"relMSE", "relMSE, trimmed", "MSE", "sMAPE", "bias"};

constexpr size_t indexOf(Metric metric) { return static_cast<size_t>(metric); }

inline PerMetric<double> metricValues(const ImageDifference& d) {
    return {d.relMse, d.trimmedRelMse, d.mse, d.smape, d.bias};
}

}  // namespace metrolux::core::study
