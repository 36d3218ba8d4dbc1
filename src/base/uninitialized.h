#pragma once
#include "base/huge_pages.h"

#include <memory>
#include <utility>
#include <vector>

namespace metrolux::core {

/// Allocator of vectors whose resize() leaves new elements as they come from memory, for large arrays that
/// several threads fill next: each element must be constructed (std::construct_at, std::uninitialized_copy)
/// before it is read. T needs no destructor.
template <class T>
struct UninitializedAllocator : HugePageAllocator<T> {
    template <class U>
    struct rebind {
        using other = UninitializedAllocator<U>;
    };
    UninitializedAllocator() = default;
    template <class U>
    UninitializedAllocator(const UninitializedAllocator<U>&) {}

    template <class U>
    void construct(U*) noexcept {}
    template <class U, class... Arguments>
    void construct(U* p, Arguments&&... arguments) {
        std::construct_at(p, std::forward<Arguments>(arguments)...);
    }
};

template <class T>
using UninitializedVector = std::vector<T, UninitializedAllocator<T>>;

}  // namespace metrolux::core
