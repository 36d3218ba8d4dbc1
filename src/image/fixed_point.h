#pragma once
/// A sum that does not depend on the order of its terms: floating-point addition is not associative, that of
/// integers is.

#include "base/math.h"

#include <array>
#include <atomic>
#include <cmath>

namespace metrolux {

/// RGB accumulator for concurrent adds. One integer unit would either overflow or lose faint light, so each
/// term goes to the accumulator of its own magnitude. A term has at most 40 significant bits in its range, so
/// that 2^23 terms of the largest size fit an accumulator before it could wrap.
class FixedPointRgb {
  public:
    /// Adds value * scale. False, and nothing is added, when a component is not finite or exceeds kLargest.
    bool add(const Rgb& value, double scale) {
        const double r = value.x * scale, g = value.y * scale, b = value.z * scale;
        // One comparison for all: a NaN makes it false.
        if (!(std::abs(r) <= kLargest && std::abs(g) <= kLargest && std::abs(b) <= kLargest)) return false;
        addComponent(0, r);
        addComponent(1, g);
        addComponent(2, b);
        return true;
    }
    /// The sum, which is reset to zero. Not for use while others add.
    std::array<double, 3> take() {
        std::array<double, 3> result;
        for (int c = 0; c < 3; ++c) {
            result[c] = 0;
            for (int range = 0; range < kRanges; ++range) {
                result[c] += static_cast<double>(sums_[range][c].load(std::memory_order_relaxed)) /
                             kUnitsPerOne[range];
                sums_[range][c].store(0, std::memory_order_relaxed);
            }
        }
        return result;
    }

    static constexpr double kLargest = 0x1p36;

  private:
    static constexpr int kRanges = 3;
    static constexpr double kUpperBound[kRanges - 1] = {0x1p-12, 0x1p12};
    static constexpr double kUnitsPerOne[kRanges] = {0x1p52, 0x1p28, 0x1p4};

    void addComponent(int component, double value) {
        if (value == 0) return;
        const double magnitude = std::abs(value);
        const int range = (magnitude >= kUpperBound[0]) + (magnitude >= kUpperBound[1]);
        // Rounding to nearest in the default mode is one instruction, and symmetric.
        const int64_t units = std::llrint(value * kUnitsPerOne[range]);
        sums_[range][component].fetch_add(units, std::memory_order_relaxed);
    }

    std::atomic<int64_t> sums_[kRanges][3] = {};
};

}  // namespace metrolux
