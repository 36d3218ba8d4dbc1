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

uint32_t owenScramble(uint32_t x, uint32_t seed) {
    return reverseBits(laineKarrasPermutation(reverseBits(x), seed));
}

/// Second dimension of Sobol's sequence; the first is the bit reversal of the index.
uint32_t sobolSecond(uint32_t index) {
    uint32_t result = 0;
    for (uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
        if (index & 1u) result ^= v;
    return result;
}

float toFloat(uint32_t x) { return static_cast<float>(x >> 8) * 0x1p-24f; }

}  // namespace

float SobolStream::next1D() {
    const uint64_t h = hashKey(key_, coordinate_++);
    // Shuffling the index keeps every power-of-two prefix a stratified set.
    const uint32_t shuffled = owenScramble(index_, static_cast<uint32_t>(h));
    return toFloat(owenScramble(reverseBits(shuffled), static_cast<uint32_t>(h >> 32)));
}

Vec2f SobolStream::next2D() {
    const uint64_t h = hashKey(key_, coordinate_), h2 = mixBits(h + 1);
    coordinate_ += 2;
    const uint32_t shuffled = owenScramble(index_, static_cast<uint32_t>(h));
    return {toFloat(owenScramble(reverseBits(shuffled), static_cast<uint32_t>(h >> 32))),
            toFloat(owenScramble(sobolSecond(shuffled), static_cast<uint32_t>(h2)))};
}

}  // namespace metrolux
