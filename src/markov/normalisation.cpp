#include "markov/normalisation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace metrolux {

void RunningMean::merge(const RunningMean& other) {
    if (other.n_ == 0) return;
    const double n = double(n_ + other.n_), delta = other.mean_ - mean_;
    m2_ += other.m2_ + delta * delta * double(n_) * double(other.n_) / n;
    mean_ += delta * double(other.n_) / n;
    n_ += other.n_;
}

double RunningMean::standardError() const {
    if (n_ < 2) return std::numeric_limits<double>::infinity();
    return std::sqrt(variance() / double(n_));
}

void Normalisation::add(int lane, const LaneSums& sums) {
    visible_.merge(sums.uniformVisible);
    size_.merge(sums.uniformSize);
    lanes_[lane].size += sums.visibilitySize;
    lanes_[lane].count += sums.visibilityCount;
}

void Normalisation::addUniform(double size) {
    visible_.add(size > 0 ? 1.0 : 0.0);
    size_.add(size);
}

Estimate Normalisation::visibility() const { return {visible_.mean(), visible_.standardError()}; }

Estimate Normalisation::contributionFromUniform() const { return {size_.mean(), size_.standardError()}; }

Estimate Normalisation::contributionFromVisibility() const {
    // Lanes are independent, so that the scatter of their means gives the error, whatever the correlation within a lane.
    double size = 0, count = 0;
    for (const Lane& lane : lanes_) {
        size += lane.size;
        count += double(lane.count);
    }
    if (!(count > 0)) return {0, std::numeric_limits<double>::infinity()};
    const double mean = size / count;
    double scatter = 0;
    int used = 0;
    for (const Lane& lane : lanes_) {
        if (lane.count == 0) continue;
        const double share = double(lane.count) / count;
        const double deviation = (lane.size / double(lane.count) - mean) * share;
        scatter += deviation * deviation;
        ++used;
    }
    if (used < 2) return {visible_.mean() * mean, std::numeric_limits<double>::infinity()};
    const double meanError = std::sqrt(scatter * used / (used - 1.0));
    const double b = visible_.mean(), bError = visible_.standardError();
    return {b * mean, std::hypot(b * meanError, bError * mean)};
}

Estimate Normalisation::contribution() const {
    const Estimate u = contributionFromUniform(), v = contributionFromVisibility();
    if (!std::isfinite(v.standardError) || !(v.value > 0)) return u;
    if (!std::isfinite(u.standardError) || !(u.value > 0)) return v;
    const double pu = 1.0 / std::max(u.standardError * u.standardError, 1e-300);
    const double pv = 1.0 / std::max(v.standardError * v.standardError, 1e-300);
    return {(u.value * pu + v.value * pv) / (pu + pv), std::sqrt(1.0 / (pu + pv))};
}

}  // namespace metrolux
