#include "integrators/pass_noise.h"

#include "base/parallel.h"

#include <algorithm>

namespace metrolux::core {

namespace {

/// Relative times of one thread. The ratio of the time of a pass of path to that of mcmc_vcm was 0.8 to 1.4
/// times what these give, on ten scenes (docs/lab/weights.md).
constexpr double kEyeVertex = 1, kKeptEyeVertex = 1.5, kLightVertex = 1.5, kConnection = 0.5, kMerge = 0.2;

/// Share of the pixels that are left out as the worst: as in trimmed relMSE.
constexpr double kWorst = 0.001;
/// How much worse eye subpaths alone may seem. They gain by their points as passes go on, and with all pixels
/// a few decide.
constexpr double kAtMost = 1.1, kAtMostAll = 1.25;
/// A half has this many passes at least, and the other half as many of it.
constexpr double kFewest = 6, kOtherHalf = 0.75;

/// Means over the film of squares, relative to the image: without the worst pixels, and of all.
std::pair<double, double> meansOf(const std::vector<float>& squares, const PixelImportance& importance) {
    std::vector<double> relative(squares.size());
    for (size_t i = 0; i < squares.size(); ++i)
        relative[i] = double(squares[i]) * sqr(double(importance.of(i)));
    const auto worst = relative.begin() + static_cast<ptrdiff_t>(double(relative.size()) * (1 - kWorst));
    std::nth_element(relative.begin(), worst, relative.end());
    double most = 0, rest = 0;
    for (auto it = relative.begin(); it != worst; ++it) most += *it;
    for (auto it = worst; it != relative.end(); ++it) rest += *it;
    const double n = double(relative.size());
    return {most / n, (most + rest) / n};
}

}  // namespace

double PassWork::eyeShare() const {
    const double whole = kKeptEyeVertex * double(eyeVertices) + kLightVertex * double(lightVertices) +
                         kConnection * double(connections) + kMerge * double(merges);
    return whole > 0 ? kEyeVertex * double(eyeVertices) / whole : 1;
}

void PassWork::add(const PassWork& other) {
    eyeVertices += other.eyeVertices;
    lightVertices += other.lightVertices;
    connections += other.connections;
    merges += other.merges;
}

void PassNoise::begin(const EyeFactors& eyes, const PixelImportance& importance, uint8_t kind,
                      int iterations) {
    open_ = true;
    if (eyeSquares_.empty()) eyeSquares_.assign(pixels_, 0.0f), eyeDifferences_ = 0;
    if (kind != kind_ || squares_.empty()) {
        squares_.assign(pixels_, 0.0f);
        last_.assign(pixels_, 0.0f);
        kind_ = kind;
        comparable_ = false;
        differences_ = 0;
        work_ = {};
    }
    tail_.pixels = double(pixels_);
    tail_.filmShare = 1.0 / iterations;
    tail_.largest = eyes.largest();
    tail_.worth.assign(tail_.largest.size(), 0.0f);
    std::vector<uint32_t> pixels(tail_.worth.size());
    for (size_t i = 0; i < pixels_; ++i) {
        const uint16_t region = eyes.regionOf(static_cast<uint32_t>(i));
        tail_.worth[region] += sqr(importance.of(i));
        ++pixels[region];
    }
    for (size_t i = 0; i < pixels.size(); ++i) tail_.worth[i] /= static_cast<float>(std::max(pixels[i], 1u));
}

void PassNoise::addEyes(const EyeFactors& eyes) {
    const bool differs = !eyeSquares_.empty() && eyes.passes() >= 2;
    parallelFor(pixels_, [&](size_t i) {
        eyeSums_[i] += double(eyes.lastOf(i));
        if (differs) eyeSquares_[i] += 0.5f * sqr(eyes.lastOf(i) - eyes.lastButOneOf(i));
    });
    eyeDifferences_ += differs;
}

void PassNoise::noteHalf(const OwnImage& image) {
    halfShown_.assign(image.sums().begin(), image.sums().end());
    halfEyeSums_ = eyeSums_;
    halfPasses_ = image.passes();
}

void PassNoise::close(const OwnImage& image, const PassWork& work) {
    parallelFor(last_.size(), [&](size_t i) {
        const auto pass = static_cast<float>(image.last()[i]);
        if (comparable_) squares_[i] += 0.5f * sqr(pass - last_[i]);
        last_[i] = pass;
    });
    differences_ += comparable_;
    comparable_ = true;
    open_ = false;
    work_.add(work);
}

void PassNoise::end() {
    comparable_ = false;
    last_ = squares_ = eyeSquares_ = {};
}

double PassNoise::Verdict::lossOfAlone() const {
    if (!(noise > 0)) return 1;
    return std::max(
        eyeShare * aloneNoise / (kAtMost * noise),
        eyeShare * (aloneAllNoise + surprise.alone) / (kAtMostAll * (allNoise + surprise.together)));
}

PassNoise::Verdict PassNoise::verdict(const OwnImage& image, const PixelImportance& importance, bool uniform,
                                      const Surprise& surprise) const {
    Verdict v;
    if (differences_ == 0 || eyeDifferences_ == 0) return v;
    const double half = halfPasses_, rest = double(image.passes()) - half;
    const bool hasHalves = half >= kFewest && rest >= kOtherHalf * half;
    const auto ofHalves = [&](std::span<const double> then, std::span<const double> now) {
        std::vector<float> variances(pixels_);
        const double scale = 1 / (1 / half + 1 / rest);
        parallelFor(pixels_, [&](size_t i) {
            variances[i] = static_cast<float>(scale * sqr(then[i] / half - (now[i] - then[i]) / rest));
        });
        return meansOf(variances, importance);
    };
    const auto ofPasses = [&](const std::vector<float>& squares, uint32_t differences) {
        const auto [most, all] = meansOf(squares, importance);
        return std::pair(most / differences, all / differences);
    };
    std::tie(v.noise, v.allNoise) =
        hasHalves && uniform ? ofHalves(halfShown_, image.sums()) : ofPasses(squares_, differences_);
    std::tie(v.aloneNoise, v.aloneAllNoise) =
        hasHalves ? ofHalves(halfEyeSums_, eyeSums_) : ofPasses(eyeSquares_, eyeDifferences_);
    v.surprise = 1 / double(pixels_) * surprise;
    v.eyeShare = work_.eyeShare();
    return v;
}

}  // namespace metrolux::core
