#pragma once
#include "geometry/intersector.h"

#include <atomic>
#include <chrono>
#include <cstdint>

namespace metrolux::core {

/// One thread's counters, on a cache line of their own. Only that thread writes; readers may see a slightly
/// old value.
struct alignas(64) RayCounters {
    std::atomic<uint64_t> intersectRays{0}, shadowRays{0}, timedNanoseconds{0};

    RayCounters();
    ~RayCounters();
    RayCounters(const RayCounters&) = delete;
    RayCounters& operator=(const RayCounters&) = delete;

    static RayCounters& ofThisThread() { return known_ ? *known_ : addThread(); }
    void count(std::atomic<uint64_t> RayCounters::*kind, uint64_t rays) { add(this->*kind, rays); }
    void addTime(std::chrono::steady_clock::duration elapsed) {
        add(timedNanoseconds, static_cast<uint64_t>(std::chrono::nanoseconds(elapsed).count()));
    }
    static RayStatistics total();

  private:
    static RayCounters& addThread();
    /// Only this thread writes: no atomic addition is needed.
    static void add(std::atomic<uint64_t>& sum, uint64_t term) {
        sum.store(sum.load(std::memory_order_relaxed) + term, std::memory_order_relaxed);
    }
    /// Spares each ray the question whether a thread_local object has been constructed.
    static constinit inline thread_local RayCounters* known_ = nullptr;
};

/// Counts rays that are traced together. The time until the end of the scope is measured if one of them is
/// the kTimedEvery-th, and shared out evenly.
class RayTimer {
  public:
    static constexpr uint64_t kTimedEvery = 64;

    explicit RayTimer(std::atomic<uint64_t> RayCounters::*kind, uint64_t rays = 1)
        : counters_(RayCounters::ofThisThread()), rays_(rays) {
        const uint64_t before = (counters_.*kind).load(std::memory_order_relaxed);
        const auto timedBefore = [](uint64_t n) { return (n + kTimedEvery - 1) / kTimedEvery; };
        timed_ = timedBefore(before + rays) - timedBefore(before);
        counters_.count(kind, rays);
        if (timed_ > 0) start_ = std::chrono::steady_clock::now();
    }
    ~RayTimer() {
        if (timed_ > 0) counters_.addTime((std::chrono::steady_clock::now() - start_) * timed_ / rays_);
    }
    RayTimer(const RayTimer&) = delete;
    RayTimer& operator=(const RayTimer&) = delete;

  private:
    RayCounters& counters_;
    std::chrono::steady_clock::time_point start_;
    uint64_t rays_, timed_;
};

}  // namespace metrolux::core
