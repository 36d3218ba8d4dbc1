#include "markov/normalization.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>

namespace metrolux::core {

void SizeHistogram::add(double size, double count) {
    if (counts_.empty()) counts_.resize(kBins);
    const double bin = std::floor((std::log2(size) + kOctaves) * kBinsOfAnOctave);
    counts_[static_cast<size_t>(std::clamp(bin, 0.0, double(kBins - 1)))] += count;
}

double SizeHistogram::sizeOf(size_t bin) {
    return std::exp2((double(bin) + 0.5) / kBinsOfAnOctave - kOctaves);
}

SizeHistogram& SizeHistogram::operator+=(const SizeHistogram& other) {
    if (counts_.size() < other.counts_.size()) counts_.resize(other.counts_.size());
    for (size_t i = 0; i < other.counts_.size(); ++i) counts_[i] += other.counts_[i];
    return *this;
}

void SizeHistogram::scale(double factor) {
    for (double& c : counts_) c *= factor;
}

double bennettMean(const SizeHistogram& ofV, const SizeHistogram& ofF) {
    double nV = 0, nF = 0, mean = 0;
    ofV.forEach([&](double size, double count) {
        nV += count;
        mean += count * size;
    });
    if (!(nV > 0)) return 0;
    mean /= nV;
    ofF.forEach([&](double, double count) { nF += count; });
    SizeHistogram all = ofV;
    all += ofF;
    constexpr int kMostRounds = 1000;
    constexpr double kTolerance = 1e-7;
    for (int round = 0; round < kMostRounds; ++round) {
        double next = 0;
        all.forEach([&](double size, double count) { next += count * size / (nV + nF * size / mean); });
        const bool done = std::abs(next - mean) <= kTolerance * mean;
        mean = next;
        if (done) break;
    }
    return mean;
}

Normalization::Counts& Normalization::Counts::operator+=(const Counts& other) {
    uniform += other.uniform;
    uniformVisible += other.uniformVisible;
    visible += other.visible;
    size += other.size;
    return *this;
}

void Normalization::add(int lane, const Samples& s) {
    current_.groups[lane % kGroups] += {s.uniform_, s.uniformVisible_, s.uniformVisible_ + s.visibility_,
                                        s.uniformSize_ + s.visibilitySize_};
    visibleSizes_ += s.visibleSizes_;
    contributionSizes_ += s.contributionSizes_;
}

void Normalization::endIteration(double squaredRadius) {
    constexpr double kRecent = 0.9;  // F changes with the radius
    visibleSizes_.scale(kRecent);
    contributionSizes_.scale(kRecent);
    current_.index = ++iterations_;
    current_.iterations = 1;
    current_.logRadius = std::log(squaredRadius);
    records_.push_back(std::move(current_));
    current_ = {};
    if (records_.size() <= kMostRecords) return;
    // Neighbors of the past are joined: what is far back is smooth and weighs little.
    std::vector<Record> joined;
    for (size_t i = 0; i + 1 < records_.size() / 2; i += 2) {
        Record &a = records_[i], &b = records_[i + 1];
        const double share = b.iterations / (a.iterations + b.iterations);
        a.index += share * (b.index - a.index);
        a.logRadius += share * (b.logRadius - a.logRadius);
        a.iterations += b.iterations;
        for (int g = 0; g < kGroups; ++g) a.groups[g] += b.groups[g];
        joined.push_back(std::move(a));
    }
    const size_t taken = 2 * joined.size();
    joined.insert(joined.end(),
                  std::make_move_iterator(records_.begin() + static_cast<std::ptrdiff_t>(taken)),
                  std::make_move_iterator(records_.end()));
    records_ = std::move(joined);
}

void Normalization::forgetSizes() {
    for (Record& r : records_)
        for (Counts& c : r.groups) c.visible = c.size = 0;
    visibleSizes_.clear();
    contributionSizes_.clear();
}

double Normalization::visibleSamples() const {
    double sum = 0;
    for (const Record& r : records_)
        for (const Counts& c : r.groups) sum += c.visible;
    return sum;
}

Normalization::Solution Normalization::solve(int withoutGroup) const {
    // Recent iterations count more: the power law need only hold locally.
    constexpr double kMemory = 2;
    std::vector<TrendPoint> visible, size;
    for (const Record& r : records_) {
        Counts sum;
        for (int g = 0; g < kGroups; ++g)
            if (g != withoutGroup) sum += r.groups[g];
        const double weight = std::pow(r.index / iterations_, kMemory);
        if (sum.uniform > 0) visible.push_back({r.logRadius, sum.uniform, sum.uniformVisible, weight});
        if (sum.visible > 0) size.push_back({r.logRadius, sum.visible, sum.size, weight});
    }
    // V cannot grow when r shrinks, nor faster than r^2. The mean size of what is visible can do both: r^-2
    // for few merges.
    const double b = std::min(1.0, fitTrend(visible, logRadius_, 0, 1)),
                 mean = fitTrend(size, logRadius_, -1.5, 1.5);
    // With no uniform samples the scale is unknown (a study of chains alone): the estimates stay what they
    // were.
    if (!(b > 0 && mean > 0)) return value_;
    return {b, b * mean};
}

void Normalization::update(double squaredRadius) {
    logRadius_ = std::log(squaredRadius);
    value_ = solve(-1);
    if (method_ == NormalizationMethod::Bennett) value_.contribution *= bennettFactor();
}

double Normalization::bennettFactor() const {
    const double bennett = bennettMean(visibleSizes_, contributionSizes_),
                 plain = bennettMean(visibleSizes_, {});
    return plain > 0 ? bennett / plain : 1;
}

Estimate Normalization::jackknife(double Solution::*which) const {
    double mean = 0;
    std::vector<double> partial;
    for (int g = 0; g < kGroups; ++g) {
        const bool used = std::any_of(records_.begin(), records_.end(),
                                      [g](const Record& r) { return r.groups[g].uniform > 0; });
        if (!used) return {value_.*which, std::numeric_limits<double>::infinity()};
        partial.push_back(solve(g).*which);
        mean += partial.back() / kGroups;
    }
    double scatter = 0;
    for (const double p : partial) scatter += (p - mean) * (p - mean);
    return {value_.*which, std::sqrt(scatter * (kGroups - 1) / kGroups)};
}

double fitTrend(const std::vector<TrendPoint>& points, double x, double gammaMin, double gammaMax) {
    // Given gamma, exp(a) is the ratio of the sums; x is the origin, so that it is the answer too.
    const auto fit = [&](double gamma, double& score) {
        double count = 0, exposure = 0, countX = 0, exposureX = 0;
        for (const TrendPoint& p : points) {
            const double d = p.x - x, n = p.weight * p.exposure * std::exp(gamma * d);
            count += p.weight * p.count;
            exposure += n;
            countX += p.weight * p.count * d;
            exposureX += n * d;
        }
        const double ratio = exposure > 0 ? count / exposure : 0;
        score = countX - ratio * exposureX;
        return ratio;
    };
    // The score falls with gamma.
    double low = gammaMin, high = gammaMax, score;
    double ratio = fit(low, score);
    if (!(score > 0)) return ratio;
    ratio = fit(high, score);
    if (!(score < 0)) return ratio;
    constexpr int kHalvings = 30;
    for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (low + high);
        ratio = fit(middle, score);
        (score > 0 ? low : high) = middle;
    }
    return ratio;
}

}  // namespace metrolux::core
