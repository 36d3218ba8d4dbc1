#include "geometry/ray_counters.h"

#include <algorithm>
#include <mutex>
#include <vector>

namespace metrolux::core {

namespace {

struct Sums {
    uint64_t intersectRays = 0, shadowRays = 0, timedNanoseconds = 0;
    void add(const RayCounters& c) {
        intersectRays += c.intersectRays.load(std::memory_order_relaxed);
        shadowRays += c.shadowRays.load(std::memory_order_relaxed);
        timedNanoseconds += c.timedNanoseconds.load(std::memory_order_relaxed);
    }
};

struct Registry {
    std::mutex mutex;
    std::vector<const RayCounters*> live;
    Sums retired;  // of threads that have ended

    Sums sum() const {
        Sums result = retired;
        for (const RayCounters* counters : live) result.add(*counters);
        return result;
    }
};

/// Never destroyed: threads may end after static objects do.
Registry& registry() {
    static Registry* const instance = new Registry;
    return *instance;
}

}  // namespace

RayCounters::RayCounters() {
    const std::lock_guard lock(registry().mutex);
    registry().live.push_back(this);
}

RayCounters::~RayCounters() {
    const std::lock_guard lock(registry().mutex);
    registry().retired.add(*this);
    std::erase(registry().live, this);
}

RayCounters& RayCounters::addThread() {
    thread_local RayCounters counters;
    known_ = &counters;
    return counters;
}

RayStatistics RayCounters::total() {
    const std::lock_guard lock(registry().mutex);
    const Sums now = registry().sum();
    return {now.intersectRays, now.shadowRays,
            1e-9 * static_cast<double>(now.timedNanoseconds * RayTimer::kTimedEvery)};
}

RayStatistics Intersector::statistics() { return RayCounters::total(); }

}  // namespace metrolux::core
