#include "image/half_sums.h"

#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>

namespace metrolux::core {

bool isOfFirstHalf(uint32_t pass) {
    if (pass < 2) return pass == 0;
    const int octave = std::bit_width(pass) - 1;
    const uint64_t within = pass - (uint64_t{1} << octave);
    if (octave == 1) return within == 1;
    const uint64_t quarter = within * 4 >> octave;
    return quarter == 0 || quarter == 3;
}

void HalfSums::enter(bool first, const Film& film) {
    passes_ += first;
    if (first == open_) return;
    if (!first) return close(film);
    const std::span<const PixelSum> sums = film.sums();
    for (size_t i = 0; i < pixels_.size(); ++i)
        for (int c = 0; c < 3; ++c) pixels_[i].begun[c] += sums[i].color[c];
    open_ = true;
}

void HalfSums::close(const Film& film) {
    if (!open_) return;
    const std::span<const PixelSum> sums = film.sums();
    for (size_t i = 0; i < pixels_.size(); ++i)
        for (int c = 0; c < 3; ++c) pixels_[i].ended[c] += sums[i].color[c];
    open_ = false;
}

void HalfSums::add(std::span<const PixelHalf> pixels, uint32_t passes) {
    if (pixels.size() != pixels_.size())
        throw Error("halves of passes: found {} pixels, expected {}", pixels.size(), pixels_.size());
    for (size_t i = 0; i < pixels.size(); ++i) pixels_[i] += pixels[i];
    passes_ += passes;
}

std::pair<std::vector<float>, std::vector<float>> HalfSums::means(const Film& film) const {
    assert(!open_ && pixels_.size() == film.sums().size());
    const std::span<const PixelSum> sums = film.sums();
    std::pair<std::vector<float>, std::vector<float>> result;
    result.first.resize(3 * sums.size());
    result.second.resize(3 * sums.size());
    const double n = passes_, rest = double(film.passes()) - n;
    const auto mean = [exponent = film.exponent()](double sum, double passes) {
        constexpr double kLargest = std::numeric_limits<float>::max();
        if (passes <= 0) return 0.0f;
        return static_cast<float>(std::clamp(std::ldexp(sum / passes, exponent), -kLargest, kLargest));
    };
    parallelFor(sums.size(), [&](size_t i) {
        for (int c = 0; c < 3; ++c) {
            const double first = pixels_[i].ended[c].value() - pixels_[i].begun[c].value();
            const size_t k = 3 * i + static_cast<size_t>(c);
            result.first[k] = mean(first, n);
            result.second[k] = mean(sums[i].color[c].value() - first, rest);
        }
    });
    return result;
}

}  // namespace metrolux::core
