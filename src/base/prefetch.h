#pragma once
#include <cstddef>

namespace metrolux {

/// Asks for memory that will be read soon. Only a hint: the address need not be valid.
template <int forWriting = 0>
void prefetch(const void* address, size_t bytes = 1) {
    constexpr size_t kLine = 64;
    const char* const first = static_cast<const char*>(address);
    for (size_t i = 0; i + 1 < bytes; i += kLine) __builtin_prefetch(first + i, forWriting);
    __builtin_prefetch(first + bytes - 1, forWriting);
    // GCC takes a function that only prefetches for one without effects, and drops calls that it does not
    // inline: of this function, of its callers. This is an effect, and no instruction.
    asm volatile("");
}

/// The same of memory that will be written to.
inline void prefetchToWrite(const void* address, size_t bytes = 1) { prefetch<1>(address, bytes); }

}  // namespace metrolux
