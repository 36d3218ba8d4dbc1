#pragma once
#include "base/rng.h"

#include <span>

/// The arithmetic of SobolStream, and the same for many streams at once.
namespace metrolux::core::sobol {

constexpr uint32_t reverseBits(uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return __builtin_bswap32(x);
}

/// Each bit is flipped by a hash of the bits below it: Owen's nested scramble of the reversed number.
constexpr uint32_t laineKarrasPermutation(uint32_t x, uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

constexpr float toFloat(uint32_t x) { return static_cast<float>(static_cast<int32_t>(x >> 8)) * 0x1p-24f; }

/// The first 32 digits of the index-th point of the second dimension of Sobol's sequence, the most
/// significant one in bit 0.
constexpr uint32_t secondReversed(uint32_t index) {
    // Direction number k is the polynomial (1 + x)^k over GF(2): the point is index(1 + x). Powers of two are
    // 1 + x^(2^j), so that one step for each bit of the exponent does it.
    index ^= (index >> 16) & 0x0000ffffu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 1) & 0x55555555u;
    return index;
}

// Owen's scramble of x is reverseBits(laineKarrasPermutation(reverseBits(x), seed)). Below, two reversals in
// a row are left out; the first dimension of Sobol's sequence is itself the reversal of the index.

/// The number of a one-dimensional pattern. `hash` names the pattern.
constexpr float point1D(uint64_t hash, uint32_t reversedIndex) {
    // Shuffling the index keeps every power-of-two prefix a stratified set.
    const uint32_t shuffled = reverseBits(laineKarrasPermutation(reversedIndex, static_cast<uint32_t>(hash)));
    return toFloat(reverseBits(laineKarrasPermutation(shuffled, static_cast<uint32_t>(hash >> 32))));
}

/// The point of a two-dimensional pattern.
inline void point2D(uint64_t hash, uint32_t reversedIndex, float& x, float& y) {
    const auto second = static_cast<uint32_t>(mixBits(hash + 1));
    const uint32_t shuffled = reverseBits(laineKarrasPermutation(reversedIndex, static_cast<uint32_t>(hash)));
    x = toFloat(reverseBits(laineKarrasPermutation(shuffled, static_cast<uint32_t>(hash >> 32))));
    y = toFloat(reverseBits(laineKarrasPermutation(secondReversed(shuffled), second)));
}

/// What SobolStream::next1D gives at `coordinate` for each of several keys (hashKey of the stream's key), of
/// the sample whose reversed index this is. Arrays of as many elements as keys.
void points1D(std::span<const uint64_t> keyHashes, uint32_t reversedIndex, uint64_t coordinate,
              float* result);
/// As SobolStream::next2D.
void points2D(std::span<const uint64_t> keyHashes, uint32_t reversedIndex, uint64_t coordinate, float* x,
              float* y);

}  // namespace metrolux::core::sobol
