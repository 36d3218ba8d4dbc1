#include "image/film.h"

#include "base/error.h"
#include "base/memory_budget.h"
#include "base/state_archive.h"
#include "image/blocking.h"
#include "image/fixed_point.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <limits>

namespace metrolux::core {

namespace {
constexpr int64_t kMostPixels = int64_t{1} << 28;

double luminanceOf(const std::array<double, 3>& rgb) {
    return 0.212671 * rgb[0] + 0.715160 * rgb[1] + 0.072169 * rgb[2];
}

/// value * 2^exponent, as near as a float comes.
float scaledFloat(double value, int exponent) {
    constexpr double kLargest = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(std::ldexp(value, exponent), -kLargest, kLargest));
}
}  // namespace

struct Film::Implementation {
    std::vector<std::array<double, 3>> eye;  ///< of the pass
    FixedPointImage splats;                  ///< of the pass
    std::vector<PixelSum> sums;              ///< of all passes
    BlockedErrorEstimate error;
    bool errorKnown = true;  ///< all passes went through `error`
    /// Of the pass; counted from all threads.
    std::atomic<uint64_t> pixelsLeftOut{0}, pixelSplatsLeftOut{0}, filmSplatsLeftOut{0};

    explicit Implementation(const FilmWindow& window)
        : eye(static_cast<size_t>(window.pixelCount())),
          splats(static_cast<size_t>(window.width), static_cast<size_t>(window.height)),
          sums(eye.size()),
          error(static_cast<uint32_t>(eye.size())) {}
};

Film::Film(const FilmWindow& window, const ReconstructionFilter& filter, int exponent)
    : window_(window), filter_(filter), exponent_(exponent) {
    if (window.width <= 0 || window.height <= 0 || window.x < 0 || window.y < 0 ||
        window.x + window.width > window.fullWidth || window.y + window.height > window.fullHeight)
        throw Error("film: the window {}x{} at ({}, {}) does not lie inside the image of {}x{} pixels",
                    window.width, window.height, window.x, window.y, window.fullWidth, window.fullHeight);
    if (static_cast<int64_t>(window.width) * window.height > kMostPixels)
        throw Error("film: {}x{} pixels are more than the largest image of {}", window.width, window.height,
                    kMostPixels);
    const uint64_t bytes = static_cast<uint64_t>(window.pixelCount()) *
                           (sizeof(Implementation::eye[0]) + sizeof(PixelSum) + FixedPointImage::kPixelBytes);
    // Memory that is promised and not there would have the system end the process in the middle of a pass.
    if (const uint64_t machine = physicalMemoryBytes(); machine > 0)
        MemoryBudget(machine).require(bytes, fmt::format("film: {}x{} pixels", window.width, window.height));
    implementation_ = std::make_shared<Implementation>(window);
}

Vec2f Film::samplePosition(uint32_t pixel, const Vec2f& u, float& weight) const {
    const auto width = static_cast<uint32_t>(window_.width);
    const int x = window_.x + static_cast<int>(pixel % width),
              y = window_.y + static_cast<int>(pixel / width);
    weight = 1;
    const float px = filter_.sample(x, window_.fullWidth, u.x, weight);
    const float py = filter_.sample(y, window_.fullHeight, u.y, weight);
    return {px, py};
}

RasterRectangle Film::reach() const {
    // From the center of a pixel the filter reaches one radius.
    const float margin = filter_.radius() - 0.5f;
    const auto low = [&](int begin) { return std::max(0.0f, static_cast<float>(begin) - margin); };
    const auto high = [&](int end, int full) {
        return std::min(static_cast<float>(full), static_cast<float>(end) + margin);
    };
    return {{low(window_.x), low(window_.y)},
            {high(window_.x + window_.width, window_.fullWidth),
             high(window_.y + window_.height, window_.fullHeight)}};
}

void Film::addEye(uint32_t pixel, const Rgb& value) {
    if (!isFinite(value)) {
        ++implementation_->pixelsLeftOut;
        return;
    }
    std::array<double, 3>& eye = implementation_->eye[pixel];
    eye[0] += value.x;
    eye[1] += value.y;
    eye[2] += value.z;
}

void Film::addSplats(const SplatList& splats, double scale) { addSplats(splats, scale, scale); }

namespace {

/// Pixels along one axis that a film splat at x reaches.
struct Reach {
    int first = 0, count = 0;
    Reach(float radius, float x, int windowBegin, int windowSize) {
        first = std::max(windowBegin, static_cast<int>(std::floor(x - radius - 0.5f)));
        const int last =
            std::min(windowBegin + windowSize - 1, static_cast<int>(std::ceil(x + radius - 0.5f)));
        // Twice the largest filter radius, and rounding.
        count = std::clamp(last - first + 1, 0, static_cast<int>(FixedPointImage::kMostColumns));
    }
};

/// Those with weights.
struct Weights {
    int first = 0;
    size_t count = 0;
    std::array<float, FixedPointImage::kMostColumns> weights;

    Weights(const ReconstructionFilter& filter, float x, int fullSize, int windowBegin, int windowSize) {
        const Reach reach(filter.radius(), x, windowBegin, windowSize);
        for (int i = 0; i < reach.count; ++i) {
            const float weight = filter.evaluate(reach.first + i, fullSize, x);
            if (count == 0 && weight == 0) continue;
            if (count == 0) first = reach.first + i;
            weights[count++] = weight;
        }
        while (count > 0 && weights[count - 1] == 0) --count;
    }
    std::span<const float> all() const { return {weights.data(), count}; }
};

/// False off the image: also keeps conversions to int in range.
bool isOnImage(const FilmWindow& window, const Vec2f& p) {
    return p.x >= 0 && p.y >= 0 && p.x <= static_cast<float>(window.fullWidth) &&
           p.y <= static_cast<float>(window.fullHeight);
}

/// Asks for the memory that splats will be added to.
void prefetch(const FixedPointImage& sums, const Film& film, const SplatList& splats) {
    const FilmWindow& w = film.window();
    const float radius = film.filter().radius();
    for (const SplatList::PixelSplat& splat : splats.pixels) sums.prefetch(splat.pixel);
    for (const SplatList::FilmSplat& splat : splats.film) {
        if (!isOnImage(w, splat.position)) continue;
        const Reach columns(radius, splat.position.x, w.x, w.width);
        const Reach rows(radius, splat.position.y, w.y, w.height);
        if (columns.count == 0) continue;
        for (int row = 0; row < rows.count; ++row)
            sums.prefetch(static_cast<size_t>(rows.first + row - w.y) * w.width +
                              static_cast<size_t>(columns.first - w.x),
                          static_cast<size_t>(columns.count));
    }
}

}  // namespace

void Film::addSplats(const SplatList& splats, double pixelScale, double filmScale) {
    FixedPointImage& film = implementation_->splats;
    prefetch(film, *this, splats);
    for (const SplatList::PixelSplat& splat : splats.pixels) {
        assert(splat.pixel < static_cast<uint32_t>(pixelCount()));
        if (!film.add(splat.pixel, splat.value, pixelScale)) ++implementation_->pixelSplatsLeftOut;
    }
    for (const SplatList::FilmSplat& splat : splats.film) {
        const Vec2f& p = splat.position;
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) {
            ++implementation_->filmSplatsLeftOut;
            continue;
        }
        if (!isOnImage(window_, p)) continue;
        const Weights columns(filter_, p.x, window_.fullWidth, window_.x, window_.width);
        const Weights rows(filter_, p.y, window_.fullHeight, window_.y, window_.height);
        if (columns.count == 0 || rows.count == 0) continue;
        if (!film.addProduct(static_cast<size_t>(columns.first - window_.x),
                             static_cast<size_t>(rows.first - window_.y), columns.all(), rows.all(),
                             splat.value, filmScale))
            ++implementation_->filmSplatsLeftOut;
    }
}

double Film::passLuminance(size_t pixel) const {
    std::array<double, 3> value = implementation_->splats.value(pixel);
    for (size_t c = 0; c < 3; ++c) value[c] += implementation_->eye[pixel][c];
    return luminanceOf(value);
}

Film::LeftOut Film::endPass() {
    if (passes_ >= kMostPasses) throw Error("film: it has {} passes and takes no more", passes_);
    Implementation& film = *implementation_;
    for (size_t i = 0; i < film.sums.size(); ++i) {
        std::array<double, 3> value = film.splats.take(i);
        for (size_t c = 0; c < 3; ++c) value[c] += std::exchange(film.eye[i][c], 0);
        const auto tooLarge = [](double x) { return !(std::abs(x) <= PixelSum::kLargest); };
        if (std::any_of(value.begin(), value.end(), tooLarge)) {
            ++film.pixelsLeftOut;
            value = {};
        }
        PixelSum& sum = film.sums[i];
        for (int c = 0; c < 3; ++c) sum.color[c].add(value[static_cast<size_t>(c)]);
        const double y = luminanceOf(value);
        sum.addSquare(y * y);
        film.error.add(static_cast<uint32_t>(i), y);
    }
    film.error.endPass();
    ++passes_;
    return {film.pixelsLeftOut.exchange(0), film.pixelSplatsLeftOut.exchange(0),
            film.filmSplatsLeftOut.exchange(0)};
}

std::vector<float> Film::image() const {
    std::vector<float> result(static_cast<size_t>(pixelCount()) * 3);
    image(result);
    return result;
}

void Film::image(std::span<float> target) const {
    assert(target.size() == 3 * static_cast<size_t>(pixelCount()));
    if (passes_ == 0) return std::fill(target.begin(), target.end(), 0.0f);
    for (size_t i = 0; i < implementation_->sums.size(); ++i)
        for (size_t c = 0; c < 3; ++c)
            target[3 * i + c] = scaledFloat(implementation_->sums[i].color[c].value() / passes_, exponent_);
}

uint64_t Film::beyondFloat() const {
    if (exponent_ == 0 || passes_ == 0) return 0;
    uint64_t count = 0;
    for (const PixelSum& sum : implementation_->sums)
        for (const auto& color : sum.color) {
            const double value = std::abs(std::ldexp(color.value() / passes_, exponent_));
            count += value > double(std::numeric_limits<float>::max()) ||
                     (value > 0 && value < double(std::numeric_limits<float>::min()));
        }
    return count;
}

std::vector<float> Film::variance() const {
    std::vector<float> result(static_cast<size_t>(pixelCount()));
    variance(result);
    return result;
}

void Film::variance(std::span<float> target) const {
    assert(target.size() == static_cast<size_t>(pixelCount()));
    if (passes_ < 2) return std::fill(target.begin(), target.end(), 0.0f);
    const double n = passes_;
    for (size_t i = 0; i < implementation_->sums.size(); ++i) {
        const PixelSum& sum = implementation_->sums[i];
        const double mean =
            luminanceOf({sum.color[0].value(), sum.color[1].value(), sum.color[2].value()}) / n;
        target[i] = scaledFloat(std::max(0.0, sum.squares() / n - mean * mean) / (n - 1), 2 * exponent_);
    }
}

double Film::relativeError() const {
    return implementation_->errorKnown ? implementation_->error.relativeError() : kInfinity;
}

template <class Archive>
void Film::serialize(Archive& archive) {
    Implementation& film = *implementation_;
    archive(passes_, film.errorKnown);
    serializeElements(archive, film.sums, "pixels");
    archive(film.error);
}
void Film::saveState(StateWriter& writer) const {
    const_cast<Film*>(this)->serialize(writer);  // a writer changes nothing
}
void Film::loadState(StateReader& reader) { serialize(reader); }

void Film::add(const Film& other) { addSums(other.sums(), other.passes()); }

std::span<const PixelSum> Film::sums() const { return implementation_->sums; }

void Film::addSums(std::span<const PixelSum> sums, uint32_t passes) {
    if (sums.size() != implementation_->sums.size())
        throw Error("film: found the sums of {} pixels, expected {}", sums.size(),
                    implementation_->sums.size());
    if (passes > kMostPasses - passes_)
        throw Error("film: {} and {} passes are more than the {} that it takes", passes_, passes,
                    kMostPasses);
    for (size_t i = 0; i < sums.size(); ++i) implementation_->sums[i] += sums[i];
    passes_ += passes;
    implementation_->errorKnown = false;
}

}  // namespace metrolux::core
