#pragma once
/// Sums that do not depend on the order of their terms: floating-point addition is not associative, that of
/// integers is.

#include "base/huge_pages.h"
#include "base/math.h"
#include "base/prefetch.h"

#include <array>
#include <atomic>
#include <cmath>
#include <vector>

namespace metrolux {

/// RGB accumulators for concurrent adds. One integer unit would either overflow or lose faint light, so each
/// term goes to the accumulator of its own magnitude. A term has at most 40 significant bits in its range, so
/// that 2^23 terms of the largest size fit an accumulator before it could wrap.
class FixedPointImage {
    static constexpr size_t kChannels = 3, kRanges = 3;

  public:
    explicit FixedPointImage(size_t pixels) : pixels_(pixels), sums_(pixels * kChannels * kRanges) {}

    /// Adds value * scale. False, and nothing is added, when a component is not finite or exceeds kLargest.
    bool add(size_t pixel, const Rgb& value, double scale) {
        const double r = value.x * scale, g = value.y * scale, b = value.z * scale;
        // A NaN makes a comparison false.
        if (!(std::abs(r) <= kLargest && std::abs(g) <= kLargest && std::abs(b) <= kLargest)) return false;
        addComponent(kChannels * pixel, r);
        addComponent(kChannels * pixel + 1, g);
        addComponent(kChannels * pixel + 2, b);
        return true;
    }
    /// Asks for the memory of the range that most terms go to.
    void prefetch(size_t pixel) const { metrolux::prefetch(&sums_[kChannels * pixel]); }

    /// The sum of a pixel, which is reset to zero. Not for use while others add.
    std::array<double, 3> take(size_t pixel) {
        std::array<double, 3> result{};
        for (size_t range = 0; range < kRanges; ++range)
            for (size_t c = 0; c < kChannels; ++c) {
                std::atomic<int64_t>& sum = sums_[(range * pixels_ + pixel) * kChannels + c];
                result[c] += static_cast<double>(sum.load(std::memory_order_relaxed)) / kUnitsPerOne[range];
                sum.store(0, std::memory_order_relaxed);
            }
        return result;
    }

    static constexpr double kLargest = 0x1p36;

    static constexpr size_t kPixelBytes = kChannels * kRanges * sizeof(std::atomic<int64_t>);

  private:
    static constexpr double kUpperBound[kRanges - 1] = {0x1p-12, 0x1p12};
    static constexpr double kUnitsPerOne[kRanges] = {0x1p52, 0x1p28, 0x1p4};

    void addComponent(size_t index, double value) {
        if (value == 0) return;
        const double magnitude = std::abs(value);
        const size_t range = (magnitude >= kUpperBound[0] ? 1 : 0) + (magnitude >= kUpperBound[1] ? 1 : 0);
        // Rounding to nearest is one instruction, and symmetric.
        const int64_t units = std::llrint(value * kUnitsPerOne[range]);
        sums_[range * kChannels * pixels_ + index].fetch_add(units, std::memory_order_relaxed);
    }

    size_t pixels_;
    // By range, then pixel: most terms are in one range, and the pixels of a filter share cache lines.
    std::vector<std::atomic<int64_t>, HugePageAllocator<std::atomic<int64_t>>> sums_;
};

}  // namespace metrolux
