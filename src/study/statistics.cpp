#include "study/statistics.h"

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace metrolux::core::study {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Moments {
    double mean = 0;
    double variance = 0;  ///< of the values, unbiased; NaN for one value
    double count = 0;
};

Moments momentsOf(const std::vector<double>& values) {
    Moments m;
    m.count = static_cast<double>(values.size());
    for (double v : values) m.mean += v / m.count;
    if (values.size() < 2) {
        m.variance = kNaN;
        return m;
    }
    for (double v : values) m.variance += (v - m.mean) * (v - m.mean) / (m.count - 1);
    return m;
}

std::vector<double> logarithms(const std::vector<double>& values) {
    std::vector<double> result;
    result.reserve(values.size());
    for (double v : values) result.push_back(std::log(v));
    return result;
}

bool allPositive(const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return v > 0; });
}

bool usable(const std::pair<double, double>& point) {
    return point.first > 0 && point.second > 0 && std::isfinite(point.first) && std::isfinite(point.second);
}

}  // namespace

Interval meanInterval(const std::vector<double>& values) {
    const Moments m = momentsOf(values);
    if (values.size() < 2) return {m.mean, kNaN, kNaN};
    const boost::math::students_t distribution(m.count - 1);
    const double reach =
        boost::math::quantile(distribution, (1 + kConfidence) / 2) * std::sqrt(m.variance / m.count);
    return {m.mean, m.mean - reach, m.mean + reach};
}

Interval geometricInterval(const std::vector<double>& values) {
    if (!allPositive(values)) return {momentsOf(values).mean, kNaN, kNaN};
    const Interval logarithmic = meanInterval(logarithms(values));
    return {std::exp(logarithmic.mean), std::exp(logarithmic.low), std::exp(logarithmic.high)};
}

PowerLaw fitPowerLaw(const std::vector<std::pair<double, double>>& points) {
    std::vector<std::pair<double, double>> logs;
    double meanX = 0, meanY = 0;
    for (const auto& point : points) {
        if (!usable(point)) continue;
        logs.emplace_back(std::log(point.first), std::log(point.second));
        meanX += logs.back().first;
        meanY += logs.back().second;
    }
    const auto n = static_cast<double>(logs.size());
    meanX /= n;
    meanY /= n;
    double xx = 0, xy = 0;
    for (const auto& [x, y] : logs) {
        xx += (x - meanX) * (x - meanX);
        xy += (x - meanX) * (y - meanY);
    }
    if (logs.size() < 2 || !(xx > 0)) return {kNaN, kNaN, kNaN, 0};
    PowerLaw fit;
    fit.points = logs.size();
    fit.slope = xy / xx;
    fit.logFactor = meanY - fit.slope * meanX;
    double residuals = 0;
    for (const auto& [x, y] : logs) residuals += std::pow(y - fit.logFactor - fit.slope * x, 2);
    fit.standardError = logs.size() > 2 ? std::sqrt(residuals / (n - 2) / xx) : kNaN;
    return fit;
}

Rate convergenceRate(const std::vector<PowerLaw>& fits) {
    std::vector<double> slopes;
    for (const PowerLaw& fit : fits)
        if (fit.points > 0) slopes.push_back(fit.slope);
    if (slopes.empty()) return {kNaN, kNaN, 0};
    const Moments m = momentsOf(slopes);
    return {m.mean, std::sqrt(m.variance / m.count), slopes.size()};
}

double welchPValue(const std::vector<double>& a, const std::vector<double>& b) {
    if (a.size() < 2 || b.size() < 2) return kNaN;
    const Moments ma = momentsOf(a), mb = momentsOf(b);
    const double va = ma.variance / ma.count, vb = mb.variance / mb.count;
    if (!(va + vb > 0)) return ma.mean == mb.mean ? 1 : 0;
    const double t = std::abs(ma.mean - mb.mean) / std::sqrt(va + vb);
    const double freedom = (va + vb) * (va + vb) / (va * va / (ma.count - 1) + vb * vb / (mb.count - 1));
    return 2 * boost::math::cdf(boost::math::complement(boost::math::students_t(freedom), t));
}

Ranking rankSmallest(const std::vector<std::vector<double>>& samples) {
    Ranking ranking;
    double best = std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < samples.size(); ++i) {
        if (samples[i].empty()) continue;
        const double mean = momentsOf(samples[i]).mean;
        if (!(mean < best)) continue;
        best = mean;
        ranking.winner = i;
    }
    if (ranking.winner == Ranking::kNone) return ranking;
    for (size_t i = 0; i < samples.size(); ++i)
        if (i != ranking.winner && welchPValue(samples[i], samples[ranking.winner]) > kSignificance)
            ranking.tied.push_back(i);
    return ranking;
}

}  // namespace metrolux::core::study
