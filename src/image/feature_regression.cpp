#include "image/feature_regression.h"

#include "base/parallel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace metrolux::core {
namespace {

// Found on eight scenes (docs/lab/denoising.md).
constexpr int kWindow = 7, kPatch = 2;  ///< radii
constexpr float kFeatureReach = 6;      ///< differences of features, in their units, that count 1/e
constexpr float kPlaceFalloff = 0.02f;  ///< exponent of the weight for the square of a pixel
/// Added to the squares of features: what varies less than a twentieth of a unit explains nothing.
constexpr float kRidge = 0.003f;
/// Neighbors of less weight are left out.
constexpr float kLeastWeight = 1e-2f;

constexpr int kSide = 2 * kWindow + 1, kOffsets = kSide * kSide;
static_assert(kWindow + kPatch <= PaddedPlane::kMargin);
/// A model is fitted around every second pixel of every second row, and tells of all pixels of its window.
constexpr int kStep = 2;
constexpr int kTileSide = 32, kCentersPerRow = (kTileSide + kStep - 1) / kStep,
              kCenters = kCentersPerRow * kCentersPerRow;
static_assert(kTileSide >= 2 * kWindow, "tiles that are written at once must not meet");
constexpr int kColumns = 16;  ///< features, colors, and zeros up to a multiple of the vector width
static_assert(kFeatures + 3 <= kColumns);

/// exp(-x) of x >= 0, relative error 1e-4. Loops with it vectorize.
float expOfMinus(float x) {
    const float exponent = std::min(x, 80.0f) * 1.44269504f;
    const float whole = std::floor(exponent), part = exponent - whole;
    const float power =
        1 + part * (-0.693147f +
                    part * (0.2402264f + part * (-0.0555041f + part * (0.0096181f - 0.0012f * part))));
    return power * std::bit_cast<float>((127 - static_cast<int32_t>(whole)) << 23);
}

/// Of weighted predictions, for one strength.
struct Sums {
    ColorPlanes color;
    PaddedPlane weight;
};

/// The models around the pixels of tiles.
class TileFilter {
  public:
    TileFilter(const RegressionInput& input, std::span<const float> strengths, std::vector<Sums>& sums)
        : input_(input),
          strengths_(strengths),
          sums_(sums),
          width_(input.trust.width()),
          height_(input.trust.height()),
          weights_(strengths.size() * kCenters * kOffsets) {}

    void run(int tileX, int tileY) {
        x0_ = tileX * kTileSide, y0_ = tileY * kTileSide;
        tileWidth_ = std::min(kTileSide, width_ - x0_), tileHeight_ = std::min(kTileSide, height_ - y0_);
        for (int dy = -kWindow; dy <= kWindow; ++dy)
            for (int dx = -kWindow; dx <= kWindow; ++dx) compare(dx, dy);
        for (size_t k = 0; k < strengths_.size(); ++k)
            for (int y = 0; y < tileHeight_; y += kStep)
                for (int x = 0; x < tileWidth_; x += kStep)
                    fit(x0_ + x, y0_ + y, weightsOf(k, x, y), sums_[k]);
    }

  private:
    using Model = float[kFeatures][kColumns];

    float* weightsOf(size_t strength, int x, int y) {
        const auto center = static_cast<size_t>(y / kStep * kCentersPerRow + x / kStep);
        return &weights_[(strength * kCenters + center) * kOffsets];
    }

    /// Weights of the neighbors at an offset, from the patches around both.
    void compare(int dx, int dy) {
        const int wide = tileWidth_ + 2 * kPatch, high = tileHeight_ + 2 * kPatch;
        for (int y = 0; y < high; ++y) {
            float* const distances = distances_[y];
            std::fill_n(distances, wide, 0.0f);
            const int px = x0_ - kPatch, py = y0_ - kPatch + y;
            for (size_t c = 0; c < 3; ++c) {
                const float *a = input_.guide[c].at(px, py), *b = input_.guide[c].at(px + dx, py + dy);
                const float *va = input_.guideVariance[c].at(px, py),
                            *vb = input_.guideVariance[c].at(px + dx, py + dy);
                for (int x = 0; x < wide; ++x) {
                    constexpr float kTiny = 1e-20f;  // images have a mean of 1
                    const float difference = a[x] - b[x];
                    distances[x] += (difference * difference - (va[x] + std::min(va[x], vb[x]))) /
                                    (va[x] + vb[x] + kTiny);
                }
            }
        }
        constexpr int kPatchSide = 2 * kPatch + 1;
        constexpr float kMean = 1.0f / (3 * kPatchSide * kPatchSide);
        for (int y = 0; y < high; ++y)
            for (int x = 0; x < tileWidth_; ++x) {
                float sum = 0;
                for (int i = 0; i < kPatchSide; ++i) sum += distances_[y][x + i];
                rows_[y][x] = sum * kMean;
            }
        const int offset = (dy + kWindow) * kSide + dx + kWindow;
        for (int y = 0; y < tileHeight_; y += kStep) {
            float means[kTileSide] = {};
            for (int i = 0; i < kPatchSide; ++i)
                for (int x = 0; x < tileWidth_; ++x) means[x] += rows_[y + i][x];
            for (size_t k = 0; k < strengths_.size(); ++k) {
                const float scale = 1 / (strengths_[k] * strengths_[k]);
                float weights[kTileSide];
                for (int x = 0; x < kTileSide; ++x) weights[x] = expOfMinus(std::max(0.0f, means[x] * scale));
                for (int x = 0; x < tileWidth_; x += kStep) weightsOf(k, x, y)[offset] = weights[x];
            }
        }
    }

    /// Fits a model around a pixel and adds what it predicts.
    void fit(int cx, int cy, float* weights, Sums& sums) const {
        const int left = std::max(-kWindow, -cx), right = std::min(kWindow, width_ - 1 - cx);
        const int top = std::max(-kWindow, -cy), bottom = std::min(kWindow, height_ - 1 - cy);
        alignas(64) Model model = {};
        const FeatureVector& center = featuresAt(cx, cy);
        for (int dy = top; dy <= bottom; ++dy) {
            float* const w = weights + (dy + kWindow) * kSide + kWindow;
            const FeatureVector* const features = &featuresAt(cx, cy + dy);
            const float* const trust = input_.trust.at(cx, cy + dy);
            const float* color[3];
            for (size_t c = 0; c < 3; ++c) color[c] = input_.color[c].at(cx, cy + dy);
            for (int dx = left; dx <= right; ++dx) {
                if (w[dx] < kLeastWeight) continue;
                alignas(64) float values[kColumns] = {1};
                for (size_t i = 1; i < kFeatures; ++i) values[i] = features[dx][i] - center[i];
                for (size_t c = 0; c < 3; ++c) values[kFeatures + c] = color[c][dx];
                float difference = 0;
                for (size_t i = 1; i < kComparedFeatures; ++i) difference += values[i] * values[i];
                w[dx] *= expOfMinus(difference / (kFeatureReach * kFeatureReach) +
                                    kPlaceFalloff * static_cast<float>(dx * dx + dy * dy));
                if (w[dx] < kLeastWeight) {
                    w[dx] = 0;
                    continue;
                }
                const float weight = w[dx] * trust[dx];
                for (size_t i = 0; i < kFeatures; ++i) {
                    const float product = weight * values[i];
                    for (size_t j = 0; j < kColumns; ++j) model[i][j] += product * values[j];
                }
            }
        }
        float coefficients[kFeatures][4] = {};
        solve(model, coefficients);
        for (int dy = top; dy <= bottom; ++dy) {
            const float* const w = weights + (dy + kWindow) * kSide + kWindow;
            const FeatureVector* const features = &featuresAt(cx, cy + dy);
            float* out[3];
            for (size_t c = 0; c < 3; ++c) out[c] = sums.color[c].at(cx, cy + dy);
            float* const weight = sums.weight.at(cx, cy + dy);
            for (int dx = left; dx <= right; ++dx) {
                if (w[dx] < kLeastWeight) continue;
                float value[4] = {coefficients[0][0], coefficients[0][1], coefficients[0][2], 0};
                for (size_t i = 1; i < kFeatures; ++i)
                    for (size_t c = 0; c < 4; ++c)
                        value[c] += (features[dx][i] - center[i]) * coefficients[i][c];
                for (size_t c = 0; c < 3; ++c) out[c][dx] += w[dx] * value[c];
                weight[dx] += w[dx];
            }
        }
    }

    /// The normal equations of a model, by Cholesky's decomposition: it has the sums of products of features,
    /// and beside them those with the colors. The mean where they have no solution.
    static void solve(const Model& model, float (&coefficients)[kFeatures][4]) {
        for (size_t c = 0; c < 3; ++c) coefficients[0][c] = model[0][kFeatures + c] / model[0][0];
        const double ridge = double(kRidge) * double(model[0][0]);
        double lower[kFeatures][kFeatures];
        for (size_t i = 0; i < kFeatures; ++i)
            for (size_t j = 0; j <= i; ++j) {
                double sum = double(model[j][i]) + (i == j && i > 0 ? ridge : 0.0);
                for (size_t k = 0; k < j; ++k) sum -= lower[i][k] * lower[j][k];
                if (i == j && !(sum > 1e-12 * double(model[i][i]))) return;
                lower[i][j] = i == j ? std::sqrt(sum) : sum / lower[j][j];
            }
        for (size_t c = 0; c < 3; ++c) {
            double solution[kFeatures];
            for (size_t i = 0; i < kFeatures; ++i) {
                double sum = double(model[i][kFeatures + c]);
                for (size_t k = 0; k < i; ++k) sum -= lower[i][k] * solution[k];
                solution[i] = sum / lower[i][i];
            }
            for (size_t i = kFeatures; i-- > 0;) {
                double sum = solution[i];
                for (size_t k = i + 1; k < kFeatures; ++k) sum -= lower[k][i] * solution[k];
                solution[i] = sum / lower[i][i];
                coefficients[i][c] = static_cast<float>(solution[i]);
            }
        }
    }

    const FeatureVector& featuresAt(int x, int y) const {
        return input_.features[static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)];
    }

    static constexpr int kWide = kTileSide + 2 * kPatch;
    const RegressionInput& input_;
    std::span<const float> strengths_;
    std::vector<Sums>& sums_;
    int width_, height_;
    int x0_ = 0, y0_ = 0, tileWidth_ = 0, tileHeight_ = 0;
    std::vector<float> weights_;  ///< of all neighbors of all centers, for each strength
    float distances_[kWide][kWide], rows_[kWide][kTileSide];
};

}  // namespace

std::vector<ColorPlanes> regress(const RegressionInput& input, std::span<const float> strengths) {
    const int width = input.trust.width(), height = input.trust.height();
    std::vector<Sums> sums(strengths.size(), {makeColorPlanes(width, height), PaddedPlane(width, height)});
    const int columns = (width + kTileSide - 1) / kTileSide, rows = (height + kTileSide - 1) / kTileSide;
    // Windows reach beyond their tiles: every second tile of every second row at a time, so that the order of
    // sums does not depend on threads.
    for (int phase = 0; phase < 4; ++phase) {
        const int firstX = phase % 2, firstY = phase / 2;
        const int acrossX = (columns - firstX + 1) / 2, acrossY = (rows - firstY + 1) / 2;
        if (acrossX <= 0 || acrossY <= 0) continue;
        parallelFor(static_cast<size_t>(acrossY), [&](size_t row) {
            TileFilter filter(input, strengths, sums);
            for (int i = 0; i < acrossX; ++i) filter.run(2 * i + firstX, 2 * static_cast<int>(row) + firstY);
        });
    }
    std::vector<ColorPlanes> result;
    for (Sums& s : sums) {
        for (size_t c = 0; c < 3; ++c)
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x) {
                    const float weight = *s.weight.at(x, y);
                    float& value = *s.color[c].at(x, y);
                    value = weight > 0 ? value / weight : *input.color[c].at(x, y);
                }
        result.push_back(std::move(s.color));
    }
    return result;
}

}  // namespace metrolux::core
