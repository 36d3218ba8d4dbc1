#include "base/distribution.h"

#include "base/error.h"

namespace metrolux::core {

DiscreteDistribution::DiscreteDistribution(std::span<const double> weights) {
    cdf_.reserve(weights.size() + 1);
    cdf_.push_back(0);
    double sum = 0;
    for (const double w : weights) {
        if (!(w >= 0) || !std::isfinite(w))
            throw Error("distribution: weight {} is negative or not finite", w);
        sum += w;
        cdf_.push_back(sum);
    }
    sum_ = sum;
    if (!(sum > 0)) return;
    for (double& c : cdf_) c /= sum;
    // The last index with weight must reach 1 exactly, so that no u falls past it.
    for (size_t i = cdf_.size(); i-- > 0 && cdf_[i] >= cdf_.back();) cdf_[i] = 1;
}

size_t DiscreteDistribution::sample(float& u) const {
    const auto it = std::upper_bound(cdf_.begin(), cdf_.end(), static_cast<double>(u));
    const size_t i = std::min<size_t>(it == cdf_.begin() ? 0 : it - cdf_.begin() - 1, size() - 1);
    const double width = cdf_[i + 1] - cdf_[i];
    u = width > 0 ? std::min(static_cast<float>((u - cdf_[i]) / width), kOneMinusEpsilon) : 0.0f;
    return i;
}

Distribution2D::Distribution2D(std::span<const float> values, int width, int height)
    : width_(width), height_(height) {
    rowCdf_.assign(height + 1, 0);
    cdf_.assign(size_t(height) * (width + 1), 0);
    std::vector<double> row(width + 1);
    double total = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const float v = values[size_t(y) * width + x];
            if (!(v >= 0) || !std::isfinite(v)) throw Error("distribution: value {} at ({}, {})", v, x, y);
            row[x + 1] = row[x] + v;
        }
        const double sum = row[width];
        for (int x = 0; x <= width; ++x)
            cdf_[size_t(y) * (width + 1) + x] =
                static_cast<float>(sum > 0 ? row[x] / sum : double(x) / width);
        total += sum;
        rowCdf_[y + 1] = total;
    }
    total_ = total / (double(width) * height);
    if (total > 0)
        for (double& c : rowCdf_) c /= total;
}

namespace {

int cellOf(float coordinate, int cells) {
    return std::clamp(static_cast<int>(coordinate * static_cast<float>(cells)), 0, cells - 1);
}

/// A coordinate of the unit interval that cellOf() finds in `cell`: rounding may not move it to a neighbor,
/// whose density is another one.
float coordinateIn(int cell, float fraction, int cells) {
    float x = std::min(static_cast<float>((cell + double(fraction)) / cells), kOneMinusEpsilon);
    while (cellOf(x, cells) > cell) x = std::nextafter(x, 0.0f);
    while (cellOf(x, cells) < cell) x = std::nextafter(x, 1.0f);
    return x;
}

}  // namespace

Vec2f Distribution2D::sample(const Vec2f& u, float& pdf) const {
    const auto it = std::upper_bound(rowCdf_.begin(), rowCdf_.end(), static_cast<double>(u.y));
    const int y = std::clamp(static_cast<int>(it - rowCdf_.begin()) - 1, 0, height_ - 1);
    const double rowWidth = rowCdf_[y + 1] - rowCdf_[y];
    const float fy = rowWidth > 0 ? static_cast<float>((u.y - rowCdf_[y]) / rowWidth) : 0.5f;

    const float* cdf = &cdf_[size_t(y) * (width_ + 1)];
    const float* jt = std::upper_bound(cdf, cdf + width_ + 1, u.x);
    const int x = std::clamp(static_cast<int>(jt - cdf) - 1, 0, width_ - 1);
    const float width = cdf[x + 1] - cdf[x];
    const float fx = width > 0 ? (u.x - cdf[x]) / width : 0.5f;

    pdf = static_cast<float>(rowWidth * height_) * width * static_cast<float>(width_);
    return {coordinateIn(x, fx, width_), coordinateIn(y, fy, height_)};
}

float Distribution2D::pdf(const Vec2f& point) const {
    const int x = cellOf(point.x, width_), y = cellOf(point.y, height_);
    const float* cdf = &cdf_[size_t(y) * (width_ + 1)];
    return static_cast<float>((rowCdf_[y + 1] - rowCdf_[y]) * height_) * (cdf[x + 1] - cdf[x]) *
           static_cast<float>(width_);
}

}  // namespace metrolux::core
