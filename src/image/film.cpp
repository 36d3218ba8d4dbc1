#include "image/film.h"

#include "base/error.h"
#include "base/memory_budget.h"
#include "image/blocking.h"
#include "image/fixed_point.h"

#include <array>
#include <cassert>

namespace metrolux {

namespace {
constexpr int64_t kMostPixels = int64_t{1} << 28;
}  // namespace

const char* techniqueName(Technique technique) {
    switch (technique) {
        case Technique::Hit:
            return "hit";
        case Technique::Nee:
            return "nee";
        case Technique::Connect:
            return "connect";
        case Technique::Splat:
            return "splat";
        case Technique::Merge:
            return "merge";
        case Technique::Count:
            break;
    }
    return "unknown";
}

struct Film::Implementation {
    struct Pixel {
        std::array<double, 3> eye{};  ///< of the pass
        std::array<double, 3> sum{};  ///< of all passes
        double sumOfSquares = 0;      ///< of the luminance of a pass
    };
    std::vector<Pixel> pixels;
    FixedPointImage splats;  ///< of the pass
    BlockedErrorEstimate error;

    explicit Implementation(int count)
        : pixels(static_cast<size_t>(count)),
          splats(static_cast<size_t>(count)),
          error(static_cast<uint32_t>(count)) {}
};

Film::Film(const FilmWindow& window, const ReconstructionFilter& filter) : window_(window), filter_(filter) {
    if (window.width <= 0 || window.height <= 0 || window.x < 0 || window.y < 0 ||
        window.x + window.width > window.fullWidth || window.y + window.height > window.fullHeight)
        throw Error("film: the window {}x{} at ({}, {}) does not lie inside the image of {}x{} pixels",
                    window.width, window.height, window.x, window.y, window.fullWidth, window.fullHeight);
    if (static_cast<int64_t>(window.width) * window.height > kMostPixels)
        throw Error("film: {}x{} pixels are more than the largest image of {}", window.width, window.height,
                    kMostPixels);
    const uint64_t bytes = static_cast<uint64_t>(window.pixelCount()) *
                           (sizeof(Implementation::Pixel) + FixedPointImage::kPixelBytes);
    // Memory that is promised and not there would have the system end the process in the middle of a pass.
    if (const uint64_t machine = physicalMemoryBytes(); machine > 0)
        MemoryBudget(machine).require(bytes, fmt::format("film: {}x{} pixels", window.width, window.height));
    implementation_ = std::make_shared<Implementation>(window.pixelCount());
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
    // From the centre of a pixel the filter reaches one radius.
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
    if (rejectNonFinite(value, Technique::Hit)) return;
    std::array<double, 3>& eye = implementation_->pixels[pixel].eye;
    eye[0] += value.x;
    eye[1] += value.y;
    eye[2] += value.z;
}

void Film::addSplats(const SplatList& splats, double scale) { addSplats(splats, scale, scale); }

namespace {
/// Pixels along one axis that a film splat reaches, with their weights.
struct Reach {
    static constexpr int kCapacity = 68;  // twice the largest filter radius, and rounding
    int first = 0, count = 0;
    std::array<float, kCapacity> weights;

    Reach(const ReconstructionFilter& filter, float x, int fullSize, int windowBegin, int windowSize) {
        const float radius = filter.radius();
        first = std::max(windowBegin, static_cast<int>(std::floor(x - radius - 0.5f)));
        const int last =
            std::min(windowBegin + windowSize - 1, static_cast<int>(std::ceil(x + radius - 0.5f)));
        count = std::clamp(last - first + 1, 0, kCapacity);
        for (int i = 0; i < count; ++i) weights[i] = filter.evaluate(first + i, fullSize, x);
    }
};
}  // namespace

void Film::addSplats(const SplatList& splats, double pixelScale, double filmScale) {
    FixedPointImage& film = implementation_->splats;
    for (const SplatList::PixelSplat& splat : splats.pixels) {
        assert(splat.pixel < static_cast<uint32_t>(pixelCount()));
        if (!film.add(splat.pixel, splat.value, pixelScale)) countNonFinite(Technique::Merge);
    }
    for (const SplatList::FilmSplat& splat : splats.film) {
        const Vec2f& p = splat.position;
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) {
            countNonFinite(Technique::Splat);
            continue;
        }
        // Off the image: also keeps the conversions to int below in range.
        if (p.x < 0 || p.y < 0 || p.x > static_cast<float>(window_.fullWidth) ||
            p.y > static_cast<float>(window_.fullHeight))
            continue;
        const Reach columns(filter_, p.x, window_.fullWidth, window_.x, window_.width);
        const Reach rows(filter_, p.y, window_.fullHeight, window_.y, window_.height);
        bool fits = true;
        for (int row = 0; row < rows.count; ++row) {
            if (rows.weights[row] == 0) continue;
            const double rowScale = filmScale * rows.weights[row];
            const size_t line = static_cast<size_t>(rows.first + row - window_.y) * window_.width +
                                static_cast<size_t>(columns.first - window_.x);
            for (int column = 0; column < columns.count; ++column)
                if (columns.weights[column] != 0)
                    fits &= film.add(line + column, splat.value, rowScale * columns.weights[column]);
        }
        if (!fits) countNonFinite(Technique::Splat);
    }
}

void Film::endPass() {
    Implementation& film = *implementation_;
    for (size_t i = 0; i < film.pixels.size(); ++i) {
        Implementation::Pixel& pixel = film.pixels[i];
        const std::array<double, 3> splats = film.splats.take(i);
        std::array<double, 3> value;
        for (int c = 0; c < 3; ++c) {
            value[c] = pixel.eye[c] + splats[c];
            pixel.sum[c] += value[c];
            pixel.eye[c] = 0;
        }
        const double y = 0.212671 * value[0] + 0.715160 * value[1] + 0.072169 * value[2];
        pixel.sumOfSquares += y * y;
        film.error.add(static_cast<uint32_t>(i), y);
    }
    film.error.endPass();
    ++passes_;
}

std::vector<float> Film::image() const {
    std::vector<float> result(static_cast<size_t>(pixelCount()) * 3, 0.0f);
    if (passes_ == 0) return result;
    for (size_t i = 0; i < implementation_->pixels.size(); ++i)
        for (int c = 0; c < 3; ++c)
            result[3 * i + c] = static_cast<float>(implementation_->pixels[i].sum[c] / passes_);
    return result;
}

std::vector<float> Film::variance() const {
    std::vector<float> result(static_cast<size_t>(pixelCount()), 0.0f);
    if (passes_ < 2) return result;
    const double n = passes_;
    for (size_t i = 0; i < implementation_->pixels.size(); ++i) {
        const Implementation::Pixel& pixel = implementation_->pixels[i];
        const double mean = (0.212671 * pixel.sum[0] + 0.715160 * pixel.sum[1] + 0.072169 * pixel.sum[2]) / n;
        result[i] = static_cast<float>(std::max(0.0, pixel.sumOfSquares / n - mean * mean) / (n - 1));
    }
    return result;
}

double Film::relativeError() const { return implementation_->error.relativeError(); }

}  // namespace metrolux
