#include "image/compare.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace metrolux::core {
namespace {

constexpr int kTile = 16;
constexpr double kTrimmedShare = 1e-3;

void checkSizes(const ImageData& a, const ImageData& b) {
    if (a.width != b.width || a.height != b.height)
        throw Error("the images differ in size: {}x{} and {}x{} pixels", a.width, a.height, b.width,
                    b.height);
}

std::array<double, 3> colorAt(const ImageData& image, int x, int y) {
    const float* p = image.at(x, y);
    if (image.channels >= 3) return {p[0], p[1], p[2]};
    return {p[0], p[0], p[0]};
}

bool isFiniteColor(const std::array<double, 3>& c) {
    return std::isfinite(c[0]) && std::isfinite(c[1]) && std::isfinite(c[2]);
}

double relativeSquare(const std::array<double, 3>& a, const std::array<double, 3>& b, double epsilon) {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) sum += sqr(a[c] - b[c]) / (sqr(b[c]) + epsilon);
    return sum / 3;
}

/// Standard error of the mean of all pixels' differences, given sums and counts of tiles.
double errorOfMean(const std::vector<double>& sums, const std::vector<size_t>& counts, double mean,
                   size_t total) {
    size_t tiles = 0;
    double squares = 0;
    for (size_t i = 0; i < sums.size(); ++i) {
        if (counts[i] == 0) continue;
        ++tiles;
        squares += sqr(sums[i] - mean * static_cast<double>(counts[i]));
    }
    if (tiles < 2) return std::numeric_limits<double>::quiet_NaN();
    const auto n = static_cast<double>(tiles);
    return std::sqrt(squares * n / (n - 1)) / static_cast<double>(total);
}

/// Position 0..1 on the scale of the heat map to a display color.
Rgb heatColor(float t) {
    static constexpr float kStops[6][3] = {{0.00f, 0.00f, 0.00f}, {0.08f, 0.12f, 0.55f},
                                           {0.55f, 0.10f, 0.60f}, {0.93f, 0.42f, 0.15f},
                                           {0.99f, 0.86f, 0.25f}, {1.00f, 1.00f, 1.00f}};
    const float position = std::clamp(t, 0.0f, 1.0f) * 5;
    const int stop = std::min(static_cast<int>(position), 4);
    const float* lower = kStops[stop];
    const float* upper = kStops[stop + 1];
    return lerp(position - static_cast<float>(stop), Rgb(lower[0], lower[1], lower[2]),
                Rgb(upper[0], upper[1], upper[2]));
}

}  // namespace

ImageDifference compareImages(const ImageData& a, const ImageData& b, double epsilon) {
    checkSizes(a, b);
    ImageDifference result;
    const int tilesX = (a.width + kTile - 1) / kTile, tilesY = (a.height + kTile - 1) / kTile;
    std::vector<double> tileSums(static_cast<size_t>(tilesX) * static_cast<size_t>(tilesY), 0.0);
    std::vector<size_t> tileCounts(tileSums.size(), 0);
    std::vector<double> relativeSquares;
    relativeSquares.reserve(static_cast<size_t>(a.width) * static_cast<size_t>(a.height));
    double sumA = 0, sumB = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            const std::array<double, 3> ca = colorAt(a, x, y), cb = colorAt(b, x, y);
            if (!isFiniteColor(ca) || !isFiniteColor(cb)) {
                ++result.nonFinite;
                continue;
            }
            double difference = 0;
            for (size_t c = 0; c < 3; ++c) {
                difference += (ca[c] - cb[c]) / 3;
                result.mse += sqr(ca[c] - cb[c]) / 3;
                sumA += ca[c] / 3;
                sumB += cb[c] / 3;
                const double size = std::abs(ca[c]) + std::abs(cb[c]);
                if (size > 0) result.smape += 2 * std::abs(ca[c] - cb[c]) / size / 3;
            }
            relativeSquares.push_back(relativeSquare(ca, cb, epsilon));
            const size_t tile =
                static_cast<size_t>(y / kTile) * static_cast<size_t>(tilesX) + static_cast<size_t>(x / kTile);
            tileSums[tile] += difference;
            ++tileCounts[tile];
        }
    }
    result.pixels = relativeSquares.size();
    if (result.pixels == 0) return result;
    const auto n = static_cast<double>(result.pixels);
    result.mse /= n;
    result.smape /= n;
    result.meanA = sumA / n;
    result.meanB = sumB / n;
    result.bias = (sumA - sumB) / sumB;
    result.biasError =
        errorOfMean(tileSums, tileCounts, (sumA - sumB) / n, result.pixels) / std::abs(result.meanB);

    // Summed in ascending order, so that one firefly does not swallow the digits of the others.
    std::sort(relativeSquares.begin(), relativeSquares.end());
    const size_t trimmed = std::min(result.pixels - 1, static_cast<size_t>(std::ceil(n * kTrimmedShare)));
    const size_t kept = result.pixels - trimmed;
    double sum = 0;
    for (size_t i = 0; i < result.pixels; ++i) {
        sum += relativeSquares[i];
        if (i + 1 == kept) result.trimmedRelMse = sum / static_cast<double>(kept);
    }
    result.relMse = sum / n;
    return result;
}

ImageData errorHeatMap(const ImageData& a, const ImageData& b, double epsilon) {
    checkSizes(a, b);
    ImageData map{a.width, a.height, 3, {}};
    map.pixels.reserve(static_cast<size_t>(a.width) * static_cast<size_t>(a.height) * 3);
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            const std::array<double, 3> ca = colorAt(a, x, y), cb = colorAt(b, x, y);
            Rgb color(0, 1, 0);
            if (isFiniteColor(ca) && isFiniteColor(cb)) {
                const double error = std::sqrt(relativeSquare(ca, cb, epsilon));
                color = heatColor(static_cast<float>(std::log10(std::max(error, 1e-3)) / 3 + 1));
            }
            map.pixels.insert(map.pixels.end(), {color.x, color.y, color.z});
        }
    }
    return map;
}

}  // namespace metrolux::core
