#include "sampling/sobol.h"

namespace metrolux::core::sobol {

// Plain loops over independent elements: the compiler makes vectors of them.

void points1D(std::span<const uint64_t> keyHashes, uint32_t reversedIndex, uint64_t coordinate,
              float* __restrict result) {
    const uint64_t* __restrict keys = keyHashes.data();
    const size_t n = keyHashes.size();
    for (size_t i = 0; i < n; ++i) result[i] = point1D(extendKey(keys[i], coordinate), reversedIndex);
}

void points2D(std::span<const uint64_t> keyHashes, uint32_t reversedIndex, uint64_t coordinate,
              float* __restrict x, float* __restrict y) {
    const uint64_t* __restrict keys = keyHashes.data();
    const size_t n = keyHashes.size();
    for (size_t i = 0; i < n; ++i) point2D(extendKey(keys[i], coordinate), reversedIndex, x[i], y[i]);
}

}  // namespace metrolux::core::sobol
