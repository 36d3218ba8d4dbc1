#include "transport/eye_factors.h"

#include "base/parallel.h"

#include <cmath>

namespace metrolux::core {

namespace {

/// Edge of a tile in pixels: small, for a floor and the caustic on it differ, and large enough that two
/// passes give its factors.
constexpr int kTile = 8;
/// Regions that PathClass::region can name.
constexpr double kMostRegions = 65535;

/// Variance over second moment that is added for a tile of one difference: a few differences without a
/// surprise do not show that there is none.
constexpr double kDoubt = 2;
/// Largest factors. A surprise that no pass has had yet comes with at most so many times the weight that it
/// has in the balance heuristic. Paths with more than one smooth vertex have many; twice the factor changes
/// nothing elsewhere (docs/lab/weights.md).
constexpr double kMostDirect = 64, kMostIndirect = 4;

int tileEdge(const FilmWindow& w) {
    int tile = kTile;
    const auto regions = [&] {
        return std::ceil(double(w.width) / tile) * std::ceil(double(w.height) / tile);
    };
    while (regions() > kMostRegions) tile += kTile;
    return tile;
}

}  // namespace

EyeFactors::EyeFactors(const FilmWindow& window)
    : window_(window),
      tile_(tileEdge(window)),
      columns_((window.width + tile_ - 1) / tile_),
      rows_((window.height + tile_ - 1) / tile_),
      current_(size_t(window.pixelCount()) * kClasses),
      previous_(current_.size()),
      second_(size_t(columns_) * size_t(rows_) * kClasses),
      variance_(second_.size()),
      factors_(second_.size(), 1.0f),
      largest_(regionCount(), 0.0f) {}

void EyeFactors::endPass() {
    parallelFor(size_t(columns_) * size_t(rows_), [&](size_t region) {
        const int x0 = static_cast<int>(region) % columns_ * tile_,
                  y0 = static_cast<int>(region) / columns_ * tile_;
        for (int y = y0; y < std::min(y0 + tile_, window_.height); ++y)
            for (int x = x0; x < std::min(x0 + tile_, window_.width); ++x) {
                const size_t pixel = size_t(y) * size_t(window_.width) + size_t(x);
                largest_[region] = std::max(largest_[region], sumOf(current_, pixel, 1));
                for (size_t k = 0; k < kClasses; ++k) {
                    const size_t i = pixel * kClasses + k, to = region * kClasses + k;
                    second_[to] += sqr(double(current_[i]));
                    if (passes_ > 0) variance_[to] += 0.5 * sqr(double(current_[i]) - double(previous_[i]));
                }
            }
    });
    std::swap(current_, previous_);
    ++passes_;
    updateFactors();
}

void EyeFactors::updateFactors() {
    if (passes_ < 2) return;
    const double differences = double(passes_ - 1) * tile_ * tile_;
    for (size_t i = 0; i < factors_.size(); ++i) {
        const size_t smooth = i % kClasses;
        if (smooth == 0 || !(second_[i] > 0)) continue;
        const double variance = variance_[i] / (passes_ - 1), second = second_[i] / passes_;
        const double ratio = variance / second + kDoubt / differences;
        factors_[i] =
            static_cast<float>(std::clamp(1 / ratio, 1.0, smooth == 1 ? kMostDirect : kMostIndirect));
    }
}

double EyeFactors::mean(int smooth) const {
    double sum = 0;
    for (size_t i = static_cast<size_t>(smooth); i < factors_.size(); i += kClasses) sum += factors_[i];
    return sum / (double(factors_.size()) / double(kClasses));
}

}  // namespace metrolux::core
