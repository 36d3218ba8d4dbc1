#include "base/memory_budget.h"

#include "base/error.h"

#include <sys/resource.h>
#include <unistd.h>

namespace metrolux::core {

uint64_t physicalMemoryBytes() {
    const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGE_SIZE);
    return pages > 0 && size > 0 ? static_cast<uint64_t>(pages) * static_cast<uint64_t>(size) : 0;
}

uint64_t peakMemoryBytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return uint64_t{1024} * static_cast<uint64_t>(usage.ru_maxrss);
}

std::string sizeText(uint64_t bytes) {
    constexpr const char* kUnits[] = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    if (bytes < 1024) return fmt::format("{} bytes", bytes);
    double value = static_cast<double>(bytes);
    size_t unit = 0;
    for (; value >= 1024; ++unit) value /= 1024;
    return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

void MemoryBudget::require(uint64_t bytes, std::string_view what) const {
    if (bytes <= total_ - used_) return;
    throw Error("{} would take {} of memory, expected at most {} ({} of {} are in use)", what,
                sizeText(bytes), sizeText(total_ - used_), sizeText(used_), sizeText(total_));
}

}  // namespace metrolux::core
