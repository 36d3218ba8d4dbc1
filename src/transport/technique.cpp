#include "transport/technique.h"

namespace metrolux::core {

const char* techniqueName(Technique technique) {
    constexpr std::array<const char*, kTechniques> kNames{"hit", "nee", "connect", "splat", "merge"};
    return kNames[static_cast<size_t>(technique)];
}

TechniqueCounts& operator+=(TechniqueCounts& a, const TechniqueCounts& b) {
    for (size_t i = 0; i < kTechniques; ++i) a[i] += b[i];
    return a;
}

TechniqueCounts NonFiniteCounts::counts() const {
    TechniqueCounts counts;
    for (size_t i = 0; i < kTechniques; ++i) counts[i] = counts_[i].load();
    return counts;
}

}  // namespace metrolux::core
