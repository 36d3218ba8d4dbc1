#pragma once
#include <cstdlib>
#include <memory>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace metrolux {

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
        const size_t bytes = (n * sizeof(T) + kPage - 1) / kPage * kPage;
        void* const memory = std::aligned_alloc(kPage, bytes);
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
    static constexpr size_t kPage = size_t{1} << 21;
    static constexpr std::align_val_t kLine{64};
    static bool isLarge(size_t n) { return n >= kPage / sizeof(T); }
};

}  // namespace metrolux
