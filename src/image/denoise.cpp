#include "image/denoise.h"

#include "base/math.h"
#include "base/parallel.h"
#include "image/feature_regression.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace metrolux::core {
namespace {

// Found on eight scenes (docs/lab/denoising.md).
constexpr std::array<float, 3> kStrengths{0.5f, 1.0f, 0.25f};
/// Differences of features that count as one.
constexpr float kAlbedoUnit = 0.05f, kNormalUnit = 0.1f, kDistanceUnit = 0.02f, kPlaceUnit = 5;
constexpr int kVarianceRadius = 4;  ///< over which the halves tell how much noise there is
constexpr float kNeighborShare = 0.3f;
/// A pixel whose variance is so many times the median around it is an outlier.
constexpr float kOutlier = 4;
constexpr int kErrorRadius = 2, kShareRadius = 2;
/// Added to squares of colors where errors are relative, of images with a mean of 1.
constexpr float kDark = 1e-3f;

/// A result that may be taken, and its squared relative error.
struct Candidate {
    ColorPlanes color;
    PaddedPlane error;
};

class Denoiser {
  public:
    explicit Denoiser(const NoisyImage& image)
        : image_(image),
          width_(image.width),
          height_(image.height),
          firstShare_(float(image.firstPasses) / float(image.passes)),
          scale_(scaleOf(image.color)),
          passVariance_(width_, height_),
          trust_(width_, height_),
          variance_(makeColorPlanes(width_, height_)),
          features_(static_cast<size_t>(width_) * static_cast<size_t>(height_)) {
        for (size_t h = 0; h < 2; ++h) {
            half_[h] = makeColorPlanes(width_, height_);
            halfVariance_[h] = makeColorPlanes(width_, height_);
        }
    }

    std::vector<float> run() {
        readImages();
        findVariances();
        findOutliers();
        readFeatures();
        return chosen(candidates());
    }

  private:
    /// A power of two that makes the mean about 1, so that squares fit and constants mean the same
    /// everywhere.
    static float scaleOf(std::span<const float> color) {
        double sum = 0;
        for (const float x : color) sum += std::abs(double(x));
        const double mean = sum / double(std::max(color.size(), size_t{1}));
        return mean > 0 ? static_cast<float>(std::ldexp(1.0, std::clamp(-std::ilogb(mean), -120, 120)))
                        : 1.0f;
    }

    template <class Body>
    void forEachPixel(Body&& body) const {
        parallelFor(static_cast<size_t>(height_), [&](size_t y) {
            for (int x = 0; x < width_; ++x)
                body(x, static_cast<int>(y), y * static_cast<size_t>(width_) + static_cast<size_t>(x));
        });
    }
    /// Share of the passes that a half has.
    float shareOf(size_t half) const { return half == 0 ? firstShare_ : 1 - firstShare_; }

    void readImages() {
        forEachPixel([&](int x, int y, size_t i) {
            for (size_t c = 0; c < 3; ++c) {
                *half_[0][c].at(x, y) = scale_ * image_.first[3 * i + c];
                *half_[1][c].at(x, y) = scale_ * image_.second[3 * i + c];
            }
            *passVariance_.at(x, y) = scale_ * scale_ * image_.variance[i];
        });
        for (ColorPlanes& half : half_)
            for (PaddedPlane& plane : half) plane.extend();
        passVariance_.extend();
    }

    /// Passes tell the noise of each pixel, but those of chains resemble each other. The difference of the
    /// halves tells the truth, but with a single value: in the mean around a pixel it scales that of the
    /// passes ([Rousselle et al. 2012]).
    void findVariances() {
        const PaddedPlane around = boxMeans(passVariance_, kVarianceRadius),
                          near = boxMeans(passVariance_, 1);
        const float toWhole = firstShare_ * (1 - firstShare_);
        for (size_t c = 0; c < 3; ++c) {
            PaddedPlane squares(width_, height_);
            forEachPixel([&](int x, int y, size_t) {
                *squares.at(x, y) = toWhole * sqr(*half_[0][c].at(x, y) - *half_[1][c].at(x, y));
            });
            const PaddedPlane byHalves = boxMeans(squares, kVarianceRadius);
            forEachPixel([&](int x, int y, size_t) {
                const float passes = *around.at(x, y);
                const float own =
                    (1 - kNeighborShare) * *passVariance_.at(x, y) + kNeighborShare * *near.at(x, y);
                const float variance = passes > 0 ? own * (*byHalves.at(x, y) / passes) : 0.0f;
                *variance_[c].at(x, y) = variance;
                for (size_t h = 0; h < 2; ++h) *halfVariance_[h][c].at(x, y) = variance / shareOf(h);
            });
            for (size_t h = 0; h < 2; ++h) halfVariance_[h][c].extend();
        }
    }

    /// A pixel that has met what its neighbors have not met yet would be spread over all of them.
    void findOutliers() {
        constexpr int kRadius = 2;
        forEachPixel([&](int x, int y, size_t) {
            std::array<float, sqr(2 * kRadius + 1)> around{};
            size_t count = 0;
            for (int j = std::max(0, y - kRadius); j <= std::min(height_ - 1, y + kRadius); ++j)
                for (int i = std::max(0, x - kRadius); i <= std::min(width_ - 1, x + kRadius); ++i)
                    around[count++] = *passVariance_.at(i, j);
            const auto middle = around.begin() + static_cast<ptrdiff_t>(count / 2);
            std::nth_element(around.begin(), middle, around.begin() + static_cast<ptrdiff_t>(count));
            const float most = kOutlier * *middle, own = *passVariance_.at(x, y);
            *trust_.at(x, y) = own > most ? std::max(most / own, 1e-6f) : 1.0f;
        });
    }

    void readFeatures() {
        double sum = 0;
        for (const float x : image_.inverseDistance) sum += double(x);
        const double mean = sum / double(std::max(image_.inverseDistance.size(), size_t{1}));
        const float distanceScale = mean > 0 ? static_cast<float>(1 / (double(kDistanceUnit) * mean)) : 0.0f;
        forEachPixel([&](int x, int y, size_t i) {
            FeatureVector& f = features_[i];
            f[0] = 1;
            for (size_t c = 0; c < 3; ++c) {
                f[1 + c] = image_.albedo[3 * i + c] / kAlbedoUnit;
                f[4 + c] = image_.normal[3 * i + c] / kNormalUnit;
            }
            f[7] = distanceScale * image_.inverseDistance[i];
            f[8] = static_cast<float>(x) / kPlaceUnit;
            f[9] = static_cast<float>(y) / kPlaceUnit;
        });
    }

    std::vector<Candidate> candidates() const {
        std::vector<ColorPlanes> first =
            regress({half_[0], half_[1], halfVariance_[1], trust_, features_}, kStrengths);
        const std::vector<ColorPlanes> second =
            regress({half_[1], half_[0], halfVariance_[0], trust_, features_}, kStrengths);
        std::vector<Candidate> result;
        for (size_t k = 0; k < kStrengths.size(); ++k) result.push_back(joined(first[k], second[k]));
        result.push_back(plain(result.front().color));
        // An outlier says nothing of the error around it.
        for (Candidate& candidate : result) {
            forEachPixel([&](int x, int y, size_t) { *candidate.error.at(x, y) *= sqr(*trust_.at(x, y)); });
            candidate.error = boxMeans(candidate.error, kErrorRadius);
        }
        return result;
    }

    /// Of the two halves' results. The error of each is its difference from the other half, less that half's
    /// noise; their mean has less, by a quarter of the square of their difference.
    Candidate joined(const ColorPlanes& first, const ColorPlanes& second) const {
        Candidate result{makeColorPlanes(width_, height_), PaddedPlane(width_, height_)};
        forEachPixel([&](int x, int y, size_t) {
            float error = 0;
            for (size_t c = 0; c < 3; ++c) {
                const float a = *first[c].at(x, y), b = *second[c].at(x, y);
                const float mean = firstShare_ * a + (1 - firstShare_) * b;
                const float errorA = sqr(a - *half_[1][c].at(x, y)) - *halfVariance_[1][c].at(x, y);
                const float errorB = sqr(b - *half_[0][c].at(x, y)) - *halfVariance_[0][c].at(x, y);
                *result.color[c].at(x, y) = mean;
                error += (0.5f * (errorA + errorB) - 0.25f * sqr(a - b)) / (sqr(mean) + kDark);
            }
            *result.error.at(x, y) = error;
        });
        return result;
    }

    /// The image as it is, whose error is its noise, relative to an `estimate`.
    Candidate plain(const ColorPlanes& estimate) const {
        Candidate result{makeColorPlanes(width_, height_), PaddedPlane(width_, height_)};
        forEachPixel([&](int x, int y, size_t i) {
            float error = 0;
            for (size_t c = 0; c < 3; ++c) {
                *result.color[c].at(x, y) = scale_ * image_.color[3 * i + c];
                error += *variance_[c].at(x, y) / (sqr(*estimate[c].at(x, y)) + kDark);
            }
            *result.error.at(x, y) = error;
        });
        return result;
    }

    /// The best at each place, with soft borders.
    std::vector<float> chosen(const std::vector<Candidate>& candidates) const {
        std::vector<PaddedPlane> shares(candidates.size(), PaddedPlane(width_, height_));
        forEachPixel([&](int x, int y, size_t) {
            size_t best = 0;
            for (size_t k = 1; k < candidates.size(); ++k)
                if (*candidates[k].error.at(x, y) < *candidates[best].error.at(x, y)) best = k;
            *shares[best].at(x, y) = 1;
        });
        for (PaddedPlane& share : shares) share = boxMeans(share, kShareRadius);
        std::vector<float> result(image_.color.size());
        forEachPixel([&](int x, int y, size_t i) {
            for (size_t c = 0; c < 3; ++c) {
                float sum = 0, weight = 0;
                for (size_t k = 0; k < candidates.size(); ++k) {
                    const float share = *shares[k].at(x, y);
                    sum += share * *candidates[k].color[c].at(x, y);
                    weight += share;
                }
                const float original = image_.color[3 * i + c], value = sum / weight / scale_;
                // A model may fall below black.
                result[3 * i + c] =
                    std::isfinite(value) ? std::max(value, std::min(0.0f, original)) : original;
            }
        });
        return result;
    }

    const NoisyImage& image_;
    int width_, height_;
    float firstShare_, scale_;
    std::array<ColorPlanes, 2> half_, halfVariance_;
    PaddedPlane passVariance_, trust_;
    ColorPlanes variance_;  ///< of the mean of all passes
    std::vector<FeatureVector> features_;
};

}  // namespace

std::vector<float> denoise(const NoisyImage& image) {
    assert(image.firstPasses > 0 && image.firstPasses < image.passes);
    return Denoiser(image).run();
}

}  // namespace metrolux::core
