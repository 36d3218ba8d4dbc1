#include "sampling/streams.h"

namespace metrolux {

namespace {

uint32_t reverseBits(uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return __builtin_bswap32(x);
}

/// Each bit is flipped by a hash of the bits below it: Owen's nested scramble of the reversed number.
uint32_t laineKarrasPermutation(uint32_t x, uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

float toFloat(uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

}  // namespace

// Owen's scramble of x is reverseBits(laineKarrasPermutation(reverseBits(x), seed)). Below, two reversals in
// a row are left out; the first dimension of Sobol's sequence is itself the reversal of the index.

uint32_t sobolSecondReversed(uint32_t index) {
    // Direction number k is the polynomial (1 + x)^k over GF(2): the point is index(1 + x). Powers of two are
    // 1 + x^(2^j), so that one step for each bit of the exponent does it.
    index ^= (index >> 16) & 0x0000ffffu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 1) & 0x55555555u;
    return index;
}

SobolStream::SobolStream(uint64_t key, uint32_t index)
    : keyHash_(hashKey(key)), reversedIndex_(reverseBits(index)) {}

uint64_t SobolStream::hash() const { return extendKey(keyHash_, coordinate_); }

float SobolStream::next1D() {
    const uint64_t h = hash();
    ++coordinate_;
    // Shuffling the index keeps every power-of-two prefix a stratified set.
    const uint32_t shuffled = reverseBits(laineKarrasPermutation(reversedIndex_, static_cast<uint32_t>(h)));
    return toFloat(reverseBits(laineKarrasPermutation(shuffled, static_cast<uint32_t>(h >> 32))));
}

Vec2f SobolStream::next2D() {
    const uint64_t h = hash(), h2 = mixBits(h + 1);
    coordinate_ += 2;
    const uint32_t shuffled = reverseBits(laineKarrasPermutation(reversedIndex_, static_cast<uint32_t>(h)));
    const uint32_t x = laineKarrasPermutation(shuffled, static_cast<uint32_t>(h >> 32));
    const uint32_t y = laineKarrasPermutation(sobolSecondReversed(shuffled), static_cast<uint32_t>(h2));
    return {toFloat(reverseBits(x)), toFloat(reverseBits(y))};
}

}  // namespace metrolux
