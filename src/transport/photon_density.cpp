#include "transport/photon_density.h"

#include "base/parallel.h"
#include "transport/cell_blocks.h"

#include <algorithm>
#include <cmath>

namespace metrolux {

PhotonDensity::PhotonDensity(double cell)
    : inverseCell_(1 / cell),
      counts_(new std::atomic<uint32_t>[kBuckets]()),
      sums_(kBuckets, 0),
      densities_(kBuckets, 0) {
    // Mean area of a plane's cut through a cell that it meets: cell^2 * 1 if parallel to a face, up to 1.3
    // aslant.
    constexpr double kMeanCut = 1.2;
    area_ = kMeanCut * cell * cell;
}

size_t PhotonDensity::bucketOf(const Vec3f& p) const {
    const auto index = [this](float x) { return static_cast<int64_t>(std::floor(double(x) * inverseCell_)); };
    return cellblocks::bucket(kBuckets / cellblocks::kCells - 1, index(p.x), index(p.y), index(p.z));
}

void PhotonDensity::endIteration(double lightSubpaths) {
    lightSubpaths_ += lightSubpaths;
    constexpr size_t kChunk = 16384;
    static_assert(kBuckets % kChunk == 0);
    parallelFor(kBuckets / kChunk, [&](size_t chunk) {
        for (size_t i = chunk * kChunk; i < (chunk + 1) * kChunk; ++i)
            sums_[i] += counts_[i].exchange(0, std::memory_order_relaxed);
    });
    updateDensities();
}

void PhotonDensity::updateDensities() {
    const double scale = lightSubpaths_ > 0 ? 1 / (lightSubpaths_ * area_) : 0;
    for (size_t i = 0; i < kBuckets; ++i) densities_[i] = static_cast<float>(sums_[i] * scale);
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

}  // namespace metrolux
