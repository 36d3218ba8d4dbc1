#pragma once
#include <cstddef>

namespace metrolux {

/// Asks for memory that will be read soon. Only a hint: the address need not be valid.
inline void prefetch(const void* address, size_t bytes = 1) {
    constexpr size_t kLine = 64;
    for (size_t i = 0; i < bytes; i += kLine) __builtin_prefetch(static_cast<const char*>(address) + i);
}

}  // namespace metrolux
