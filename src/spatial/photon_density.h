#pragma once
#include "base/math.h"
#include "base/state.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace metrolux::core {

/// Density of light subpaths' vertices on surfaces, averaged over the iterations so far, from counts in the
/// cells of a hash grid. It steers weights only: collisions in the table and cells that a surface crosses
/// aslant cost efficiency, never brightness.
class PhotonDensity {
  public:
    /// `cell`: edge of a cell in scene units, > 0.
    explicit PhotonDensity(double cell);

    /// Counts so many vertices. Thread-safe; sums do not depend on the order. No effect on densities until
    /// endIteration().
    void count(const Vec3f& p, uint32_t vertices = 1) { count(bucketOf(p), vertices); }
    /// The same in two steps.
    using Bucket = uint32_t;
    Bucket bucketOf(const Vec3f& p) const;
    void count(Bucket bucket, uint32_t vertices = 1) {
        counts_[bucket].fetch_add(vertices, std::memory_order_relaxed);
    }
    /// Closes an iteration in which the vertices of so many light subpaths were counted.
    void endIteration(double lightSubpaths);
    /// Expected number of vertices per light subpath and area around p; 0 before the first iteration has
    /// ended.
    double at(const Vec3f& p) const { return densities_[bucketOf(p)]; }
    /// at() to within 1/16, from a table a quarter as large: every vertex asks, and would wait for memory. 0
    /// where fewer than 2^-28 vertices of a subpath are expected in the cell.
    float roughlyAt(const Vec3f& p) const { return levels_[codes_[bucketOf(p)]]; }

    /// Of what count(bucket) changes and roughlyAt() reads there.
    const void* addressOfCounter(Bucket bucket) const { return &counts_[bucket]; }
    const void* addressOfLevel(Bucket bucket) const { return &codes_[bucket]; }

    /// Between two iterations.
    template <class Archive>
    void serialize(Archive& archive) {
        std::vector<uint32_t> buckets;  // most lie where no surface is
        std::vector<double> sums;
        used(buckets, sums);
        archive(lightSubpaths_, buckets, sums);
        setUsed(buckets, sums);
    }

  private:
    void used(std::vector<uint32_t>& buckets, std::vector<double>& sums) const;
    void setUsed(const std::vector<uint32_t>& buckets, const std::vector<double>& sums);
    void updateDensities();
    /// Calls body(bucket) for all, from many threads.
    template <class Body>
    void forBuckets(Body&& body);

    static constexpr size_t kBuckets = size_t{1} << 18;

    double inverseCell_, area_, lightSubpaths_ = 0;
    std::unique_ptr<std::atomic<uint32_t>[]> counts_;
    std::vector<double> sums_;
    std::vector<float> densities_;
    std::vector<uint8_t> codes_;  ///< the same, as indices of levels_
    std::array<float, 256> levels_{};
};

}  // namespace metrolux::core
