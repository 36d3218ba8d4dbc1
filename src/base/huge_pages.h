#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace metrolux::core {

inline constexpr size_t kHugePage = size_t{1} << 21;

/// Wishes for pages of 2 MB under an array that exists already: what lies on small pages is moved, by systems
/// that can (Linux 6.1), now. Addresses and contents stay.
inline void preferHugePages([[maybe_unused]] const void* array, [[maybe_unused]] size_t bytes) {
#ifdef MADV_HUGEPAGE
    const auto begin = (reinterpret_cast<uintptr_t>(array) + kHugePage - 1) / kHugePage * kHugePage;
    const auto end = (reinterpret_cast<uintptr_t>(array) + bytes) / kHugePage * kHugePage;
    if (begin >= end) return;
    void* const first = reinterpret_cast<void*>(begin);
    madvise(first, end - begin, MADV_HUGEPAGE);
    constexpr int kCollapse = 25;  // MADV_COLLAPSE, which glibc 2.36 has no name for
    madvise(first, end - begin, kCollapse);
#endif
}

/// Allocator for large arrays that are read here and there: the system is asked for pages of 2 MB, so that an
/// access does not wait for the page table before it waits for memory. Small arrays come from the heap. All
/// begin at a cache line.
template <class T>
struct HugePageAllocator : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = HugePageAllocator<U>;
    };
    HugePageAllocator() = default;
    template <class U>
    HugePageAllocator(const HugePageAllocator<U>&) {}

    T* allocate(size_t n) {
        if (!isLarge(n)) return static_cast<T*>(::operator new(n * sizeof(T), kLine));
        const size_t bytes = (n * sizeof(T) + kHugePage - 1) / kHugePage * kHugePage;
        void* const memory = std::aligned_alloc(kHugePage, bytes);
        if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
        madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: without it all is as before
#endif
        return static_cast<T*>(memory);
    }
    void deallocate(T* p, size_t n) {
        if (isLarge(n))
            std::free(p);
        else
            ::operator delete(p, kLine);
    }
    friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }

  private:
    static constexpr std::align_val_t kLine{64};
    static bool isLarge(size_t n) { return n >= kHugePage / sizeof(T); }
};

}  // namespace metrolux::core
