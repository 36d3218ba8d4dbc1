#pragma once
/// Sums that do not depend on the order of their terms: floating-point addition is not associative, that of
/// integers is.

#include "base/huge_pages.h"
#include "base/math.h"
#include "base/prefetch.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <vector>

namespace metrolux::core {

/// RGB accumulators for concurrent adds. One integer unit would either overflow or lose faint light, so each
/// term goes to the accumulator of its own magnitude. A term has at most 40 significant bits in its range.
/// Before an accumulator could wrap, its upper bits move to a word of their own: a tile of pixels counts how
/// often it has been added to.
///
/// Who adds holds the lock of a tile: one atomic operation for a splat of 25 pixels with 75 sums.
class FixedPointImage {
    static constexpr size_t kChannels = 3, kRanges = 3;

  public:
    FixedPointImage(size_t width, size_t height)
        : width_(width),
          pixels_(width * height),
          tilesAcross_((width + kTile - 1) / kTile),
          sums_(pixels_ * kChannels * kRanges),
          tiles_(tilesAcross_ * ((height + kTile - 1) / kTile)) {}

    /// Adds value * scale. False, and nothing is added, when a component is not finite or exceeds kLargest.
    bool add(size_t pixel, const Rgb& value, double scale) {
        const Hold hold(*this, pixel % width_, pixel / width_);
        return addHeld(pixel, value, scale);
    }

    /// Adds value * scale * rows[j] * columns[i] to each pixel (x + i, y + j), at most kMostColumns wide.
    /// False when that could not be added to all of them.
    bool addProduct(size_t x, size_t y, std::span<const float> columns, std::span<const float> rows,
                    const Rgb& value, double scale) {
        assert(columns.size() <= kMostColumns);
        const double largest =  // or more; not finite if anything is
            (std::abs(double(value.x)) + std::abs(double(value.y)) + std::abs(double(value.z))) *
            std::abs(scale) * largestOf(columns) * largestOf(rows);
        // None in the highest range, as is usual: then rows are added as vectors.
        const bool usual = largest < 0.99 * kUpperBound[1];
        std::array<double, kChannels * kMostColumns> values, weights;
        if (usual)
            for (size_t i = 0; i < columns.size(); ++i)
                for (size_t c = 0; c < kChannels; ++c) {
                    values[kChannels * i + c] = value[static_cast<int>(c)];
                    weights[kChannels * i + c] = columns[i];
                }
        bool fits = true;
        for (size_t top = 0, bottom; top < rows.size(); top = bottom) {
            bottom = std::min(rows.size(), tileEnd(y + top) - y);
            for (size_t left = 0, right; left < columns.size(); left = right) {
                right = std::min(columns.size(), tileEnd(x + left) - x);
                const Hold hold(*this, x + left, y + top);
                for (size_t j = top; j < bottom; ++j) {
                    const double rowScale = scale * rows[j];
                    const size_t line = (y + j) * width_ + x;
                    if (usual)
                        addUsual(kChannels * (line + left), &values[kChannels * left],
                                 &weights[kChannels * left], kChannels * (right - left), rowScale);
                    else
                        for (size_t i = left; i < right; ++i)
                            fits &= addHeld(line + i, value, rowScale * columns[i]);
                }
            }
        }
        return fits;
    }
    static constexpr size_t kMostColumns = 68;

    /// Asks for the memory of some pixels of a line, of the ranges that most terms go to.
    void prefetch(size_t pixel, size_t count = 1) const {
        for (size_t range = 0; range < 2; ++range)
            metrolux::core::prefetchToWrite(&sums_[kChannels * (range * pixels_ + pixel)],
                                            kChannels * count * sizeof(int64_t));
    }

    /// The sum of a pixel. Not for use while others add.
    std::array<double, 3> value(size_t pixel) const {
        const size_t x = pixel % width_, y = pixel / width_;
        const int64_t* const carried = tileAt(x, y).carried.get();
        std::array<double, 3> result{};
        for (size_t range = 0; range < kRanges; ++range)
            for (size_t c = 0; c < kChannels; ++c) {
                const int64_t sum = sums_[(range * pixels_ + pixel) * kChannels + c];
                const double units =
                    carried ? sumOf(carried[carriedIndex(x, y, range, c)], sum) : static_cast<double>(sum);
                result[c] += units / kUnitsPerOne[range];
            }
        return result;
    }
    /// The same, and resets it to zero.
    std::array<double, 3> take(size_t pixel) {
        const std::array<double, 3> result = value(pixel);
        const size_t x = pixel % width_, y = pixel / width_;
        int64_t* const carried = tileAt(x, y).carried.get();
        for (size_t range = 0; range < kRanges; ++range)
            for (size_t c = 0; c < kChannels; ++c) {
                sums_[(range * pixels_ + pixel) * kChannels + c] = 0;
                if (carried) carried[carriedIndex(x, y, range, c)] = 0;
            }
        return result;
    }

    static constexpr double kLargest = 0x1p36;

    static constexpr size_t kPixelBytes = kChannels * kRanges * sizeof(int64_t);

  private:
    static constexpr double kUpperBound[kRanges - 1] = {0x1p-12, 0x1p12};
    static constexpr double kUnitsPerOne[kRanges] = {0x1p52, 0x1p28, 0x1p4};

    /// A square of pixels whose sums one thread changes at a time. Threads that splat to the same place wait
    /// for some tens of nanoseconds; a tile has a cache line, so that others do not.
    static constexpr size_t kTile = 32;
    struct alignas(64) Tile {
        std::atomic<bool> held{false};
        uint32_t holds = 0;  ///< since the last carry(); a pixel gets at most a term in each
        std::unique_ptr<int64_t[]> carried;
    };
    class Hold {
      public:
        Hold(FixedPointImage& image, size_t x, size_t y) : tile_(image.tileAt(x, y)) {
            for (int tries = 1; tile_.held.exchange(true, std::memory_order_acquire); ++tries)
                if (tries % 64 == 0) std::this_thread::yield();  // its holder may wait for this processor
            if (++tile_.holds == kMostHolds) image.carry(x, y);
        }
        ~Hold() { tile_.held.store(false, std::memory_order_release); }
        Hold(const Hold&) = delete;
        Hold& operator=(const Hold&) = delete;

      private:
        Tile& tile_;
    };
    Tile& tileAt(size_t x, size_t y) { return tiles_[y / kTile * tilesAcross_ + x / kTile]; }
    const Tile& tileAt(size_t x, size_t y) const { return tiles_[y / kTile * tilesAcross_ + x / kTile]; }
    static size_t tileEnd(size_t x) { return (x / kTile + 1) * kTile; }

    static constexpr uint32_t kMostHolds = uint32_t{1} << 22;
    static constexpr int kCarriedBits = 40;
    static size_t carriedIndex(size_t x, size_t y, size_t range, size_t channel) {
        return ((y % kTile * kTile + x % kTile) * kRanges + range) * kChannels + channel;
    }
    static double sumOf(int64_t upper, int64_t lower) {
        __extension__ using Integer = __int128;
        return static_cast<double>(static_cast<Integer>(upper) * (int64_t{1} << kCarriedBits) + lower);
    }
    /// Leaves what is below 2^kCarriedBits in the accumulators of a tile, which the caller holds.
    void carry(size_t x, size_t y) {
        Tile& tile = tileAt(x, y);
        tile.holds = 0;
        if (!tile.carried) tile.carried = std::make_unique<int64_t[]>(kTile * kTile * kRanges * kChannels);
        const size_t left = x / kTile * kTile, top = y / kTile * kTile;
        for (size_t j = top; j < std::min(tileEnd(y), pixels_ / width_); ++j)
            for (size_t i = left; i < std::min(tileEnd(x), width_); ++i)
                for (size_t range = 0; range < kRanges; ++range)
                    for (size_t c = 0; c < kChannels; ++c) {
                        int64_t& sum = sums_[(range * pixels_ + j * width_ + i) * kChannels + c];
                        const int64_t upper = sum >> kCarriedBits;
                        tile.carried[carriedIndex(i, j, range, c)] += upper;
                        sum -= upper * (int64_t{1} << kCarriedBits);
                    }
    }

    static double largestOf(std::span<const float> weights) {
        float largest = 0;
        for (const float w : weights) largest = std::max(largest, std::abs(w));
        return largest;
    }

    /// add() of who holds the tile.
    bool addHeld(size_t pixel, const Rgb& value, double scale) {
        const std::array<double, 3> terms{value.x * scale, value.y * scale, value.z * scale};
        // A NaN makes a comparison false.
        if (!(std::abs(terms[0]) <= kLargest && std::abs(terms[1]) <= kLargest &&
              std::abs(terms[2]) <= kLargest))
            return false;
        for (size_t c = 0; c < kChannels; ++c) {
            const double magnitude = std::abs(terms[c]);
            const size_t range =
                (magnitude >= kUpperBound[0] ? 1 : 0) + (magnitude >= kUpperBound[1] ? 1 : 0);
            sums_[(range * pixels_ + pixel) * kChannels + c] += rounded(terms[c] * kUnitsPerOne[range]);
        }
        return true;
    }

    /// The same for terms below the highest range that lie side by side: without branches, so that compilers
    /// make vectors of it.
    void addUsual(size_t first, const double* values, const double* weights, size_t count, double scale) {
        int64_t* const faint = &sums_[first];
        int64_t* const middle = &sums_[kChannels * pixels_ + first];
        for (size_t i = 0; i < count; ++i) {
            const double term = values[i] * (scale * weights[i]);
            const bool isFaint = std::abs(term) < kUpperBound[0];
            const int64_t asFaint = rounded(isFaint ? term * kUnitsPerOne[0] : 0.0),
                          asMiddle = rounded(isFaint ? 0.0 : term * kUnitsPerOne[1]);
            faint[i] += asFaint;
            middle[i] += asMiddle;
        }
    }

    /// To the nearest integer, |x| < 2^51: the sum has no bits below one.
    static int64_t rounded(double x) {
        constexpr double kNoFraction = 0x1.8p52;
        return std::bit_cast<int64_t>(x + kNoFraction) - std::bit_cast<int64_t>(kNoFraction);
    }

    size_t width_, pixels_, tilesAcross_;
    // By range, then pixel: most terms are in one range, and the pixels of a filter share cache lines.
    std::vector<int64_t, HugePageAllocator<int64_t>> sums_;
    std::vector<Tile> tiles_;
};

}  // namespace metrolux::core
