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
    // A state that a new target has made invisible is no sample of the chain: counted in N_F but not among the visible
    // samples it would take its place from the uniform ones, and b_V would fall without end.
    if (!(size > 0 && weight > 0)) return;
    contribution_ += weight;
    visible_.push_back({size, weight});
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

double Normalisation::visibleUniformSamples() const {
    double sum = 0;
    for (const Sums& g : groups_) sum += g.uniformVisible;
    return sum;
}

void Normalisation::discount(double factor) {
    for (Sums& g : groups_) {
        for (double* sum : {&g.uniform, &g.uniformVisible, &g.uniformSize, &g.uniformSize2, &g.visibility,
                            &g.visibilitySize, &g.contribution})
            *sum *= factor;
        for (double& w : g.weight) w *= factor;
        for (double& w : g.size) w *= factor;
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
    // With no uniform samples the scale is unknown (a study of chains alone): the estimates stay what they were.
    if (bins.empty() || !(s.uniform > 0)) return {bVisibility_, bContribution_};

    // The fixed point is the minimum over x = log b_V, y = log b_F of the convex function
    //     sum_j w_j log(N_U + N_V e^-x + N_F F_j e^-y) + N_V x + N_F y
    // [Shirts & Chodera 2008]. Newton's method with halved steps finds it from anywhere.
    const auto value = [&](double x, double y) {
        double sum = s.visibility * x + s.contribution * y;
        for (const Bin& j : bins)
            sum += j.weight * std::log(s.uniform + s.visibility * std::exp(-x) + s.contribution * j.size * std::exp(-y));
        return sum;
    };
    double x = std::log(bVisibility_), y = std::log(bContribution_);
    double now = value(x, y);
    constexpr int kSteps = 200;
    for (int step = 0; step < kSteps; ++step) {
        double gx = s.visibility, gy = s.contribution, hxx = 0, hyy = 0, hxy = 0;
        for (const Bin& j : bins) {
            const double v = s.visibility * std::exp(-x), f = s.contribution * j.size * std::exp(-y);
            const double pv = v / (s.uniform + v + f), pf = f / (s.uniform + v + f);
            gx -= j.weight * pv;
            gy -= j.weight * pf;
            hxx += j.weight * pv * (1 - pv);
            hyy += j.weight * pf * (1 - pf);
            hxy -= j.weight * pv * pf;
        }
        // A replica without samples has no say; a flat function far from the minimum is tilted a little.
        const double ridge = 1e-12 * (s.uniform + s.visibility + s.contribution);
        hxx += ridge;
        hyy += ridge;
        const double determinant = hxx * hyy - hxy * hxy;
        constexpr double kLongest = 5;
        double dx = std::clamp((hxy * gy - hyy * gx) / determinant, -kLongest, kLongest);
        double dy = std::clamp((hxy * gx - hxx * gy) / determinant, -kLongest, kLongest);
        double next = value(x + dx, y + dy);
        for (int halving = 0; halving < 40 && !(next <= now); ++halving) {
            dx *= 0.5;
            dy *= 0.5;
            next = value(x + dx, y + dy);
        }
        if (!(next <= now)) break;  // as near as rounding allows
        x += dx;
        y += dy;
        now = next;
        if (std::abs(dx) + std::abs(dy) < 1e-10) break;
    }
    // For a replica without samples the minimum says nothing: its normalisation is the sum over the others' samples.
    Solution result{0, 0};
    for (const Bin& j : bins) {
        const double w =
            j.weight / (s.uniform + s.visibility * std::exp(-x) + s.contribution * j.size * std::exp(-y));
        result.visibility += w;
        result.contribution += w * j.size;
    }
    result.visibility = std::min(result.visibility, 1.0);
    return result;
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
