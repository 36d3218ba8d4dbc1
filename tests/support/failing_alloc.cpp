/// A library to be loaded before others (LD_PRELOAD): one call of operator new fails. Calls count from the
/// moment when the program asks for the scene, so that what the loader of the system allocates is left alone.
/// Environment:
///
///     FAILING_ALLOC_FILE  the count begins when a file of this name is looked at
///     FAILING_ALLOC_CALL  number of the call that fails, from 1; 0: none
///     FAILING_ALLOC_LOG   file that gets the number of calls at the end

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <new>
#include <sys/stat.h>
#include <unistd.h>

namespace {

std::atomic<long> calls{0};
std::atomic<bool> counts{false};
long chosen = 0;

void watch(const char* path) {
    const char* name = std::getenv("FAILING_ALLOC_FILE");
    if (counts || !name || !path) return;
    const char* slash = std::strrchr(path, '/');
    if (std::strcmp(slash ? slash + 1 : path, name) != 0) return;
    const char* call = std::getenv("FAILING_ALLOC_CALL");
    chosen = call ? std::atol(call) : 0;
    counts = true;
}

void* allocated(std::size_t size, std::size_t alignment) {
    if (counts && ++calls == chosen) return nullptr;
    if (size == 0) size = 1;
    if (alignment <= __STDCPP_DEFAULT_NEW_ALIGNMENT__) return std::malloc(size);
    return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

/// As that of the library does.
void* orThrow(void* memory) {
    if (memory) return memory;
    if (const std::new_handler handler = std::get_new_handler()) handler();
    throw std::bad_alloc();
}
void* orNull(void* memory) noexcept {
    try {
        return orThrow(memory);
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
}

struct Report {
    ~Report() {
        const char* log = std::getenv("FAILING_ALLOC_LOG");
        if (!log) return;
        if (std::FILE* file = std::fopen(log, "w")) {
            std::fprintf(file, "%ld\n", calls.load());
            std::fclose(file);
        }
    }
} report;

}  // namespace

void* operator new(std::size_t size) { return orThrow(allocated(size, 1)); }
void* operator new[](std::size_t size) { return orThrow(allocated(size, 1)); }
void* operator new(std::size_t size, std::align_val_t a) { return orThrow(allocated(size, std::size_t(a))); }
void* operator new[](std::size_t size, std::align_val_t a) {
    return orThrow(allocated(size, std::size_t(a)));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return orNull(allocated(size, 1)); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return orNull(allocated(size, 1)); }
void* operator new(std::size_t size, std::align_val_t a, const std::nothrow_t&) noexcept {
    return orNull(allocated(size, std::size_t(a)));
}
void* operator new[](std::size_t size, std::align_val_t a, const std::nothrow_t&) noexcept {
    return orNull(allocated(size, std::size_t(a)));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { std::free(memory); }

extern "C" int stat(const char* path, struct stat* status) {
    watch(path);
    static auto* const next =
        reinterpret_cast<int (*)(const char*, struct stat*)>(::dlsym(RTLD_NEXT, "stat"));
    return next(path, status);
}
