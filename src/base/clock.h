#pragma once
#include <ctime>

namespace metrolux::core {

/// Seconds of a clock of the system. CLOCK_MONOTONIC has any origin; CLOCK_PROCESS_CPUTIME_ID counts what all
/// threads of this process have worked.
inline double secondsOf(clockid_t clock) {
    timespec t{};
    ::clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

inline double steadySeconds() { return secondsOf(CLOCK_MONOTONIC); }
inline double processorSeconds() { return secondsOf(CLOCK_PROCESS_CPUTIME_ID); }

}  // namespace metrolux::core
