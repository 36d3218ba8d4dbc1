#include "image/blocking.h"

#include "base/rng.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace metrolux::core {

BlockedErrorEstimate::BlockedErrorEstimate(uint32_t pixelCount) {
    const uint32_t count = std::min(pixelCount, kLargestSubset);
    series_.resize(count);
    for (uint64_t i = 0; i < count; ++i) {
        const uint64_t begin = i * pixelCount / count, end = (i + 1) * pixelCount / count;
        series_[i].pixel = static_cast<uint32_t>(begin + hashKey(i, pixelCount) % (end - begin));
    }
}

void BlockedErrorEstimate::Series::add(double value, uint32_t passesBefore) {
    sum += value;
    double block = value;
    for (int l = 0; l < kLevels; ++l) {
        Level& level = levels[l];
        const uint32_t before = passesBefore >> l;  // complete blocks of this level so far
        const double delta = block - level.mean;
        level.mean += delta / (before + 1);
        level.squares += delta * (block - level.mean);
        if ((before & 1) == 0) {
            level.pending = block;
            return;
        }
        block = 0.5 * (level.pending + block);
    }
}

void BlockedErrorEstimate::endPass() {
    next_ = 0;
    ++passes_;
}

double BlockedErrorEstimate::relativeError() const {
    constexpr double kUnknown = std::numeric_limits<double>::infinity();
    if (passes_ < kLeastBlocks || series_.empty()) return kUnknown;
    double imageMean = 0;
    for (const Series& s : series_) imageMean += s.sum / passes_;
    imageMean /= static_cast<double>(series_.size());
    const double darkness = kDarkness * imageMean * imageMean;
    if (!(darkness > 0)) return kUnknown;

    double largest = 0;
    for (int l = 0; l < kLevels; ++l) {
        const uint32_t blocks = passes_ >> l;
        if (blocks < (l == 0 ? kLeastBlocks : kPlateauBlocks)) break;
        double squaredError = 0;
        for (const Series& s : series_) {
            const double mean = s.sum / passes_;
            const double variance = s.levels[l].squares / (static_cast<double>(blocks - 1) * blocks);
            squaredError += variance / (mean * mean + darkness);
        }
        largest = std::max(largest, squaredError / static_cast<double>(series_.size()));
    }
    return std::sqrt(largest);
}

}  // namespace metrolux::core
