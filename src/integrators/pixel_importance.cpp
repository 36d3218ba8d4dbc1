#include "integrators/pixel_importance.h"

#include <algorithm>
#include <cmath>

namespace metrolux::core {

namespace {

/// Sums over 2 reach + 1 neighbors along a row or column, fewer at its ends; returns the means.
std::vector<double> boxBlur(const std::vector<double>& in, int length, int lines, int step, int lineStep,
                            int reach) {
    std::vector<double> out(in.size());
    for (int line = 0; line < lines; ++line)
        for (int i = 0; i < length; ++i) {
            const int low = std::max(0, i - reach), high = std::min(length - 1, i + reach);
            double sum = 0;
            for (int k = low; k <= high; ++k) sum += in[size_t(line) * lineStep + size_t(k) * step];
            out[size_t(line) * lineStep + size_t(i) * step] = sum / (high - low + 1);
        }
    return out;
}

}  // namespace

void PixelImportance::update(const OwnImage& image, double darkest) {
    window_ = image.window();
    const size_t n = image.sums().size();
    values_.assign(n, 1.0f);
    if (image.passes() == 0) return;
    std::vector<double> shown(n);
    double mean = 0;
    for (size_t i = 0; i < n; ++i) {
        // Filters with negative lobes can make a pixel negative.
        shown[i] = std::max(0.0, image.sums()[i] / image.passes());
        mean += shown[i] / double(n);
    }
    if (!(mean > 0)) return;
    shown = boxBlur(shown, window_.width, window_.height, 1, window_.width, kReach);
    shown = boxBlur(shown, window_.height, window_.width, window_.width, 1, kReach);
    double worth = 0;
    for (const double s : shown) worth += s / (s + darkest * mean) / double(n);
    for (size_t i = 0; i < n; ++i)
        values_[i] = static_cast<float>(mean / (worth * (shown[i] + darkest * mean)));
}

double PixelImportance::sizeOf(const SplatList::FilmSplat& splat) const {
    // The filter spreads splats from around the window too: the nearest pixel stands for those.
    const int x =
        std::clamp(static_cast<int>(std::floor(splat.position.x)) - window_.x, 0, window_.width - 1);
    const int y =
        std::clamp(static_cast<int>(std::floor(splat.position.y)) - window_.y, 0, window_.height - 1);
    return double(magnitude(splat.value) * values_[size_t(y) * size_t(window_.width) + size_t(x)]);
}

double PixelImportance::size(const SplatList& splats) const {
    double sum = 0;
    for (const SplatList::PixelSplat& splat : splats.pixels) sum += sizeOf(splat);
    for (const SplatList::FilmSplat& splat : splats.film) sum += sizeOf(splat);
    return sum;
}

double PixelImportance::squares(const SplatList& splats, double ofFilm) const {
    double sum = 0;
    for (const SplatList::PixelSplat& splat : splats.pixels) sum += sqr(sizeOf(splat));
    for (const SplatList::FilmSplat& splat : splats.film) sum += ofFilm * sqr(sizeOf(splat));
    return sum;
}

}  // namespace metrolux::core
