#pragma once
#include "base/rng.h"

#include <cstdint>

namespace metrolux::core::cellblocks {

/// Tables of a grid's cells that are reached by a hash: blocks of 4 x 2 x 2 cells are hashed as one and lie
/// side by side, 16 values of four bytes in a cache line, so that what is near in space is near in memory.
constexpr int kShiftX = 2, kShiftY = 1, kShiftZ = 1;
constexpr uint32_t kCells = 1 << (kShiftX + kShiftY + kShiftZ);

/// Hash of the block of a cell, which may be made of parts that several cells share:
/// keyZ(keyY(keyX(x), y), z). A sum with odd factors is different for all blocks that a scene can have; it is
/// mixed once, at the end.
constexpr uint64_t keyX(int64_t x) { return static_cast<uint64_t>(x >> kShiftX) * 0x9e3779b97f4a7c15ULL; }
constexpr uint64_t keyY(uint64_t key, int64_t y) {
    return key + static_cast<uint64_t>(y >> kShiftY) * 0xd1b54a32d192ed03ULL;
}
constexpr uint64_t keyZ(uint64_t key, int64_t z) {
    return mixBits(key + static_cast<uint64_t>(z >> kShiftZ) * 0xabc98388fb8fac03ULL);
}

/// Index of a cell in a table of blockMask + 1 blocks, a power of two. Cells with different places in their
/// blocks never have the same.
constexpr uint32_t bucket(uint64_t key, uint32_t blockMask, int64_t x, int64_t y, int64_t z) {
    const int64_t place = (x & ((1 << kShiftX) - 1)) | (y & ((1 << kShiftY) - 1)) << kShiftX |
                          (z & ((1 << kShiftZ) - 1)) << (kShiftX + kShiftY);
    return (static_cast<uint32_t>(key) & blockMask) * kCells + static_cast<uint32_t>(place);
}
constexpr uint32_t bucket(uint32_t blockMask, int64_t x, int64_t y, int64_t z) {
    return bucket(keyZ(keyY(keyX(x), y), z), blockMask, x, y, z);
}

}  // namespace metrolux::core::cellblocks
