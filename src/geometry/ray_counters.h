#pragma once
#include "geometry/intersector.h"

#include <atomic>
#include <chrono>
#include <cstdint>

namespace metrolux {

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
    void addTime(std::chrono::steady_clock::duration elapsed, uint64_t share = 1) {
        const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(elapsed).count();
        add(timedNanoseconds, static_cast<uint64_t>(nanoseconds) / share);
    }
    static RayStatistics total();
    static void reset();

  private:
    static RayCounters& addThread();
    /// Only this thread writes: no atomic addition is needed.
    static void add(std::atomic<uint64_t>& sum, uint64_t term) {
        sum.store(sum.load(std::memory_order_relaxed) + term, std::memory_order_relaxed);
    }
    /// Spares each ray the question whether a thread_local object has been constructed.
    static constinit inline thread_local RayCounters* known_ = nullptr;
};

/// Counts a ray and, for one in kTimedEvery, the time until the end of the scope.
class RayTimer {
  public:
    static constexpr uint64_t kTimedEvery = 64;

    explicit RayTimer(std::atomic<uint64_t> RayCounters::*kind) : counters_(RayCounters::ofThisThread()) {
        timed_ = (counters_.*kind).load(std::memory_order_relaxed) % kTimedEvery == 0;
        counters_.count(kind, 1);
        if (timed_) start_ = std::chrono::steady_clock::now();
    }
    ~RayTimer() {
        if (timed_) counters_.addTime(std::chrono::steady_clock::now() - start_);
    }
    RayTimer(const RayTimer&) = delete;
    RayTimer& operator=(const RayTimer&) = delete;

  private:
    RayCounters& counters_;
    std::chrono::steady_clock::time_point start_;
    bool timed_ = false;
};

/// Counts the rays of a batch and their time, which enters the sum as that of one ray in kTimedEvery would.
class BatchTimer {
  public:
    BatchTimer(std::atomic<uint64_t> RayCounters::*kind, uint64_t rays)
        : counters_(RayCounters::ofThisThread()), start_(std::chrono::steady_clock::now()) {
        counters_.count(kind, rays);
    }
    ~BatchTimer() { counters_.addTime(std::chrono::steady_clock::now() - start_, RayTimer::kTimedEvery); }
    BatchTimer(const BatchTimer&) = delete;
    BatchTimer& operator=(const BatchTimer&) = delete;

  private:
    RayCounters& counters_;
    std::chrono::steady_clock::time_point start_;
};

}  // namespace metrolux
