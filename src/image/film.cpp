#include "image/film.h"

#include "base/error.h"
#include "base/memory_budget.h"
#include "base/state_archive.h"
#include "image/blocking.h"
#include "image/fixed_point.h"

#include <array>
#include <cassert>

namespace metrolux {

namespace {
constexpr int64_t kMostPixels = int64_t{1} << 28;

double luminanceOf(const std::array<double, 3>& rgb) {
    return 0.212671 * rgb[0] + 0.715160 * rgb[1] + 0.072169 * rgb[2];
}
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
    std::vector<std::array<double, 3>> eye;  ///< of the pass
    FixedPointImage splats;                  ///< of the pass
    std::vector<PixelSum> sums;              ///< of all passes
    BlockedErrorEstimate error;
    bool errorKnown = true;  ///< all passes went through `error`

    explicit Implementation(int count)
        : eye(static_cast<size_t>(count)),
          splats(static_cast<size_t>(count)),
          sums(static_cast<size_t>(count)),
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
                           (sizeof(Implementation::eye[0]) + sizeof(PixelSum) + FixedPointImage::kPixelBytes);
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
    std::array<double, 3>& eye = implementation_->eye[pixel];
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
    // Atomic additions wait for memory one after the other: all is asked for first.
    for (const SplatList::PixelSplat& splat : splats.pixels) film.prefetch(splat.pixel);
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
    for (size_t i = 0; i < film.sums.size(); ++i) {
        std::array<double, 3> value = film.splats.take(i);
        for (size_t c = 0; c < 3; ++c) value[c] += std::exchange(film.eye[i][c], 0);
        const auto tooLarge = [](double x) { return !(std::abs(x) <= PixelSum::kLargest); };
        if (std::any_of(value.begin(), value.end(), tooLarge)) {
            countNonFinite(Technique::Hit);
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
    ++passIndex_;
}

std::vector<float> Film::image() const {
    std::vector<float> result(static_cast<size_t>(pixelCount()) * 3, 0.0f);
    if (passes_ == 0) return result;
    for (size_t i = 0; i < implementation_->sums.size(); ++i)
        for (size_t c = 0; c < 3; ++c)
            result[3 * i + c] = static_cast<float>(implementation_->sums[i].color[c].value() / passes_);
    return result;
}

std::vector<float> Film::variance() const {
    std::vector<float> result(static_cast<size_t>(pixelCount()), 0.0f);
    if (passes_ < 2) return result;
    const double n = passes_;
    for (size_t i = 0; i < implementation_->sums.size(); ++i) {
        const PixelSum& sum = implementation_->sums[i];
        const double mean =
            luminanceOf({sum.color[0].value(), sum.color[1].value(), sum.color[2].value()}) / n;
        result[i] = static_cast<float>(std::max(0.0, sum.squares() / n - mean * mean) / (n - 1));
    }
    return result;
}

double Film::relativeError() const {
    return implementation_->errorKnown ? implementation_->error.relativeError() : kInfinity;
}

TechniqueCounts Film::nonFinite() const {
    TechniqueCounts counts;
    for (size_t i = 0; i < counts.size(); ++i) counts[i] = nonFinite_[i].load();
    return counts;
}

template <class Archive>
void Film::serialize(Archive& archive) {
    Implementation& film = *implementation_;
    TechniqueCounts nonFinite = this->nonFinite();
    archive(passes_, passIndex_, film.errorKnown);
    serializeElements(archive, nonFinite, "techniques");
    serializeElements(archive, film.sums, "pixels");
    archive(film.error);
    for (size_t i = 0; i < nonFinite.size(); ++i) nonFinite_[i].store(nonFinite[i]);
}
void Film::saveState(StateWriter& writer) const {
    const_cast<Film*>(this)->serialize(writer);  // a writer changes nothing
}
void Film::loadState(StateReader& reader) { serialize(reader); }

void Film::add(const Film& other) { addSums(other.sums(), other.passes(), other.nonFinite()); }

std::span<const PixelSum> Film::sums() const { return implementation_->sums; }

void Film::addSums(std::span<const PixelSum> sums, uint32_t passes, const TechniqueCounts& nonFinite) {
    if (sums.size() != implementation_->sums.size())
        throw Error("film: found the sums of {} pixels, expected {}", sums.size(),
                    implementation_->sums.size());
    for (size_t i = 0; i < sums.size(); ++i) implementation_->sums[i] += sums[i];
    for (size_t i = 0; i < nonFinite.size(); ++i) nonFinite_[i].fetch_add(nonFinite[i]);
    passes_ += passes;
    implementation_->errorKnown = false;
}

}  // namespace metrolux
