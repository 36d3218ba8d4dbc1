#pragma once
#include "base/math.h"

#include <cstdint>

namespace metrolux::core {

/// Bijective 64-bit finalizer (Stafford's variant 13 of the MurmurHash3 finalizer, as used by SplitMix64).
constexpr uint64_t mixBits(uint64_t x) {
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9ULL;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebULL;
    x ^= x >> 31;
    return x;
}

/// Hash of the words behind `key` and one more: extendKey(hashKey(a), b) = hashKey(a, b).
constexpr uint64_t extendKey(uint64_t key, uint64_t word) {
    return mixBits(key ^ word) + 0x9e3779b97f4a7c15ULL;
}

/// Hash of several words into one key; the order of the words matters.
template <class... Words>
constexpr uint64_t hashKey(Words... words) {
    uint64_t h = 0x9e3779b97f4a7c15ULL;
    ((h = extendKey(h, static_cast<uint64_t>(words))), ...);
    return h;
}

/// Uniform in [0, 1) with 24 bits.
constexpr float toUnitFloat(uint64_t bits) { return static_cast<float>(bits >> 40) * 0x1p-24f; }

/// Counter-based generator: the i-th value depends on (key, i) only, so that a stream can be entered anywhere
/// and two streams with different keys are independent for all purposes of this program.
class CounterRng {
  public:
    explicit constexpr CounterRng(uint64_t key, uint64_t counter = 0) : key_(key), counter_(counter) {}
    constexpr uint64_t nextBits() { return mixBits(key_ + 0x9e3779b97f4a7c15ULL * ++counter_); }
    constexpr float next1D() { return toUnitFloat(nextBits()); }
    Vec2f next2D() {
        const uint64_t bits = nextBits();
        return {toUnitFloat(bits), toUnitFloat(bits << 24)};
    }
    /// Uniform in [0, 1) with 53 bits.
    constexpr double nextDouble() { return static_cast<double>(nextBits() >> 11) * 0x1p-53; }
    constexpr uint64_t counter() const { return counter_; }
    constexpr uint64_t key() const { return key_; }
    constexpr void seek(uint64_t counter) { counter_ = counter; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(key_, counter_);
    }

  private:
    uint64_t key_, counter_;
};

}  // namespace metrolux::core
