#pragma once
#include <cstddef>
#include <cstdint>

namespace metrolux::core {

/// Asks for memory that will be read soon. Only a hint: the address need not be valid, and there may be no
/// bytes.
template <int forWriting = 0>
void prefetch(const void* address, size_t bytes = 1) {
    constexpr size_t kLine = 64;
    // As a number: sums of pointers must stay within an object.
    const auto first = reinterpret_cast<uintptr_t>(address);
    const auto ask = [](uintptr_t at) { __builtin_prefetch(reinterpret_cast<const void*>(at), forWriting); };
    for (size_t i = 0; i + 1 < bytes; i += kLine) ask(first + i);
    ask(first + bytes - 1);
    // GCC takes a function that only prefetches for one without effects, and drops calls that it does not
    // inline: of this function, of its callers. This is an effect, and no instruction.
    asm volatile("");
}

/// The same of memory that will be written to.
inline void prefetchToWrite(const void* address, size_t bytes = 1) { prefetch<1>(address, bytes); }

}  // namespace metrolux::core
