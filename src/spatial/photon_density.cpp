#include "spatial/photon_density.h"

#include "base/parallel.h"
#include "spatial/cell_blocks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace metrolux::core {

namespace {

/// Logarithms of expected counts, in 255 codes of an eighth of an octave from 2^-28 up (0: less than that):
/// the exponent and the first bits of the mantissa of a float.
constexpr int kCodeShift = std::numeric_limits<float>::digits - 1 - 3;
constexpr uint32_t kLowestCode = std::bit_cast<uint32_t>(0x1p-28f) >> kCodeShift;

uint8_t codeOf(float expected) {
    const uint32_t code = std::bit_cast<uint32_t>(expected) >> kCodeShift;
    return code < kLowestCode ? uint8_t{0} : static_cast<uint8_t>(std::min(code - kLowestCode + 1, 255u));
}
/// The middle of what has this code.
float levelOf(uint32_t code) {
    if (code == 0) return 0;
    return std::bit_cast<float>((code - 1 + kLowestCode) << kCodeShift | 1u << (kCodeShift - 1));
}

}  // namespace

PhotonDensity::PhotonDensity(double cell)
    : inverseCell_(1 / cell),
      counts_(new std::atomic<uint32_t>[kBuckets]()),
      sums_(kBuckets, 0),
      densities_(kBuckets, 0),
      codes_(kBuckets, 0) {
    // Mean area of a plane's cut through a cell that it meets: cell^2 * 1 if parallel to a face, up to 1.3
    // aslant.
    constexpr double kMeanCut = 1.2;
    area_ = kMeanCut * cell * cell;
}

PhotonDensity::Bucket PhotonDensity::bucketOf(const Vec3f& p) const {
    const auto index = [this](float x) { return static_cast<int64_t>(std::floor(double(x) * inverseCell_)); };
    return cellblocks::bucket(kBuckets / cellblocks::kCells - 1, index(p.x), index(p.y), index(p.z));
}

template <class Body>
void PhotonDensity::forBuckets(Body&& body) {
    constexpr size_t kChunk = 16384;
    static_assert(kBuckets % kChunk == 0);
    parallelFor(kBuckets / kChunk, [&](size_t chunk) {
        for (size_t i = chunk * kChunk; i < (chunk + 1) * kChunk; ++i) body(i);
    });
}

void PhotonDensity::endIteration(double lightSubpaths) {
    lightSubpaths_ += lightSubpaths;
    forBuckets([&](size_t i) { sums_[i] += counts_[i].exchange(0, std::memory_order_relaxed); });
    updateDensities();
}

void PhotonDensity::updateDensities() {
    const double perSubpath = lightSubpaths_ > 0 ? 1 / lightSubpaths_ : 0;
    forBuckets([&](size_t i) {
        const double expected = sums_[i] * perSubpath;
        densities_[i] = static_cast<float>(expected / area_);
        codes_[i] = codeOf(static_cast<float>(expected));
    });
    for (uint32_t code = 0; code < levels_.size(); ++code)
        levels_[code] = static_cast<float>(levelOf(code) / area_);
}

void PhotonDensity::used(std::vector<uint32_t>& buckets, std::vector<double>& sums) const {
    for (size_t i = 0; i < kBuckets; ++i) {
        if (sums_[i] == 0) continue;
        buckets.push_back(static_cast<uint32_t>(i));
        sums.push_back(sums_[i]);
    }
}

void PhotonDensity::setUsed(const std::vector<uint32_t>& buckets, const std::vector<double>& sums) {
    checkState(buckets.size() == sums.size(), "a sum for each bucket");
    std::fill(sums_.begin(), sums_.end(), 0);
    for (size_t i = 0; i < buckets.size(); ++i) {
        checkState(buckets[i] < kBuckets, "a bucket of the table");
        sums_[buckets[i]] = sums[i];
    }
    updateDensities();
}

}  // namespace metrolux::core
