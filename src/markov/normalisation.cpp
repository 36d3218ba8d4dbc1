#include "markov/normalisation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace metrolux {

void Normalisation::Samples::addUniform(double size) {
    uniform_ += 1;
    uniformSize_ += size;
    uniformSize2_ += size * size;
    if (!(size > 0)) return;
    uniformVisible_ += 1;
    visible_.push_back({size, 1});
}

void Normalisation::Samples::addVisibility(double size) {
    visibility_ += 1;
    visibilitySize_ += size;
    visible_.push_back({size, 1});
}

void Normalisation::Samples::addContribution(double size, double weight) {
    contribution_ += weight;
    if (size > 0 && weight > 0) visible_.push_back({size, weight});
}

void Normalisation::Samples::clear() {
    std::vector<Entry> memory;
    memory.swap(visible_);
    memory.clear();
    *this = {};
    visible_.swap(memory);
}

int Normalisation::binOf(double size) {
    // 16 bins per octave over 256 octaves; the mean of F within a bin is kept, so that the width hardly matters.
    return std::clamp(static_cast<int>(std::floor(std::log2(size) * 16.0)) + kBins / 2, 0, kBins - 1);
}

void Normalisation::add(int lane, const Samples& s) {
    Sums& g = groups_[lane % kGroups];
    if (g.weight.empty()) {
        g.weight.assign(kBins, 0);
        g.size.assign(kBins, 0);
    }
    g.uniform += s.uniform_;
    g.uniformVisible += s.uniformVisible_;
    g.uniformSize += s.uniformSize_;
    g.uniformSize2 += s.uniformSize2_;
    g.visibility += s.visibility_;
    g.visibilitySize += s.visibilitySize_;
    g.contribution += s.contribution_;
    for (const Samples::Entry& e : s.visible_) {
        const int bin = binOf(e.size);
        g.weight[bin] += e.weight;
        g.size[bin] += e.weight * e.size;
    }
}

Normalisation::Sums Normalisation::total(int withoutGroup) const {
    Sums t;
    t.weight.assign(kBins, 0);
    t.size.assign(kBins, 0);
    for (int i = 0; i < kGroups; ++i) {
        const Sums& g = groups_[i];
        if (i == withoutGroup || g.weight.empty()) continue;
        t.uniform += g.uniform;
        t.uniformVisible += g.uniformVisible;
        t.uniformSize += g.uniformSize;
        t.uniformSize2 += g.uniformSize2;
        t.visibility += g.visibility;
        t.visibilitySize += g.visibilitySize;
        t.contribution += g.contribution;
        for (int b = 0; b < kBins; ++b) {
            t.weight[b] += g.weight[b];
            t.size[b] += g.size[b];
        }
    }
    return t;
}

Normalisation::Solution Normalisation::solve(const Sums& s) const {
    struct Bin {
        double weight, size;
    };
    std::vector<Bin> bins;
    for (int b = 0; b < kBins; ++b)
        if (s.weight[b] > 0) bins.push_back({s.weight[b], s.size[b] / s.weight[b]});
    Solution x{bVisibility_, bContribution_};
    if (bins.empty()) return x;
    // With no uniform samples the scale is unknown (a study of chains alone): the estimates stay what they were.
    if (!(s.uniform > 0)) return x;

    // Root of a decreasing function of log b.
    const auto root = [](auto&& excess, double start) {
        double low = std::log(start) - 1, high = low + 2;
        while (excess(std::exp(low)) < 0 && low > -600) low -= 4;
        while (excess(std::exp(high)) > 0 && high < 600) high += 4;
        for (int i = 0; i < 60 && high - low > 1e-12; ++i) {
            const double middle = 0.5 * (low + high);
            (excess(std::exp(middle)) > 0 ? low : high) = middle;
        }
        return std::exp(0.5 * (low + high));
    };
    // Dividing the fixed-point equations by b makes their sides monotonous in b.
    constexpr int kRounds = 100;
    for (int round = 0; round < kRounds; ++round) {
        const Solution before = x;
        x.visibility = root(
            [&](double b) {
                double sum = 0;
                for (const Bin& j : bins)
                    sum += j.weight / (s.uniform * b + s.visibility + s.contribution * j.size * b / x.contribution);
                return sum - 1;
            },
            x.visibility);
        x.contribution = root(
            [&](double b) {
                double sum = 0;
                for (const Bin& j : bins)
                    sum += j.weight / ((s.uniform + s.visibility / x.visibility) * b / j.size + s.contribution);
                return sum - 1;
            },
            x.contribution);
        if (std::abs(std::log(x.visibility / before.visibility)) < 1e-9 &&
            std::abs(std::log(x.contribution / before.contribution)) < 1e-9)
            break;
    }
    x.visibility = std::min(x.visibility, 1.0);
    return x;
}

void Normalisation::update() {
    const Solution x = solve(total());
    bVisibility_ = x.visibility;
    bContribution_ = x.contribution;
}

Estimate Normalisation::jackknife(double Solution::*which) const {
    const double all = solve(total()).*which;
    double mean = 0;
    std::vector<double> partial;
    for (int i = 0; i < kGroups; ++i) {
        if (groups_[i].weight.empty()) return {all, std::numeric_limits<double>::infinity()};
        partial.push_back(solve(total(i)).*which);
        mean += partial.back() / kGroups;
    }
    double scatter = 0;
    for (const double p : partial) scatter += (p - mean) * (p - mean);
    return {all, std::sqrt(scatter * (kGroups - 1) / kGroups)};
}

Estimate Normalisation::visibilityFromUniform() const {
    const Sums t = total();
    if (!(t.uniform > 0)) return {0, std::numeric_limits<double>::infinity()};
    const double p = t.uniformVisible / t.uniform;
    return {p, std::sqrt(p * (1 - p) / t.uniform)};
}

Estimate Normalisation::contributionFromUniform() const {
    const Sums t = total();
    if (!(t.uniform > 0)) return {0, std::numeric_limits<double>::infinity()};
    const double mean = t.uniformSize / t.uniform;
    return {mean, std::sqrt(std::max(0.0, t.uniformSize2 / t.uniform - mean * mean) / t.uniform)};
}

double Normalisation::contributionFromVisibility() const {
    const Sums t = total();
    return t.visibility > 0 ? visibilityFromUniform().value * t.visibilitySize / t.visibility : 0;
}

}  // namespace metrolux
