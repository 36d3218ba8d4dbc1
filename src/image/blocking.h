#pragma once
#include "base/state.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace metrolux::core {

/// Error of a mean of passes that may be correlated, by blocking: Flyvbjerg & Petersen 1989, Error estimates
/// on averages of correlated data. At level l the series is replaced by means of 2^l consecutive passes; the
/// variance of the mean that follows from them rises with l until the blocks are independent.
class BlockedErrorEstimate {
  public:
    /// Watches at most kLargestSubset of `pixelCount` pixels, one in each of as many strata.
    explicit BlockedErrorEstimate(uint32_t pixelCount);

    /// Value of a pixel in this pass; to be called for all pixels in ascending order.
    void add(uint32_t pixel, double luminance) {
        if (next_ < series_.size() && series_[next_].pixel == pixel) series_[next_++].add(luminance, passes_);
    }
    void endPass();

    template <class Archive>
    void serialize(Archive& archive) {
        archive(passes_);
        checkState(passes_ < (uint32_t{1} << kLevels), "fewer passes");
        for (Series& s : series_) {
            archive(s.sum);
            // Higher levels have seen nothing.
            for (int l = 0; (passes_ >> l) > 0; ++l)
                archive(s.levels[l].pending, s.levels[l].mean, s.levels[l].squares);
        }
    }

    /// Root of the mean over the watched pixels of  Var[mean] / (mean^2 + kDarkness * m^2), m the mean of all
    /// of them. Infinity with fewer than kLeastBlocks passes, and for a black image.
    double relativeError() const;

    static constexpr uint32_t kLargestSubset = 4096;
    static constexpr double kDarkness = 1e-2;

  private:
    static constexpr int kLevels = 24;              // 2^24 passes and more
    static constexpr uint32_t kLeastBlocks = 8;     // at the finest level
    static constexpr uint32_t kPlateauBlocks = 16;  // at the others: fewer give a maximum made of noise

    struct Series {
        uint32_t pixel = 0;
        double sum = 0;
        struct Level {
            double pending = 0;            ///< an odd block that waits for its partner
            double mean = 0, squares = 0;  ///< of complete blocks (Welford)
        };
        std::array<Level, kLevels> levels{};
        void add(double value, uint32_t passesBefore);
    };
    std::vector<Series> series_;  // ascending pixels
    size_t next_ = 0;
    uint32_t passes_ = 0;
};

}  // namespace metrolux::core
