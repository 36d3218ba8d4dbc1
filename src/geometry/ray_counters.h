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

    static RayCounters& ofThisThread() { return known_ ? *known_ : add(); }
    static RayStatistics total();
    static void reset();

  private:
    static RayCounters& add();
    /// Spares each ray the question whether a thread_local object has been constructed.
    static constinit inline thread_local RayCounters* known_ = nullptr;
};

/// Counts a ray and, for one in kTimedEvery, the time until the end of the scope.
class RayTimer {
  public:
    static constexpr uint64_t kTimedEvery = 64;

    explicit RayTimer(std::atomic<uint64_t> RayCounters::*kind) : counters_(RayCounters::ofThisThread()) {
        auto& counter = counters_.*kind;
        const uint64_t count = counter.load(std::memory_order_relaxed);
        counter.store(count + 1, std::memory_order_relaxed);
        timed_ = count % kTimedEvery == 0;
        if (timed_) start_ = std::chrono::steady_clock::now();
    }
    ~RayTimer() {
        if (!timed_) return;
        const auto elapsed = std::chrono::steady_clock::now() - start_;
        auto& sum = counters_.timedNanoseconds;
        const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(elapsed).count();
        sum.store(sum.load(std::memory_order_relaxed) + static_cast<uint64_t>(nanoseconds),
                  std::memory_order_relaxed);
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
        auto& counter = counters_.*kind;
        counter.store(counter.load(std::memory_order_relaxed) + rays, std::memory_order_relaxed);
    }
    ~BatchTimer() {
        const auto elapsed = std::chrono::steady_clock::now() - start_;
        const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(elapsed).count();
        auto& sum = counters_.timedNanoseconds;
        sum.store(
            sum.load(std::memory_order_relaxed) + static_cast<uint64_t>(nanoseconds) / RayTimer::kTimedEvery,
            std::memory_order_relaxed);
    }
    BatchTimer(const BatchTimer&) = delete;
    BatchTimer& operator=(const BatchTimer&) = delete;

  private:
    RayCounters& counters_;
    std::chrono::steady_clock::time_point start_;
};

}  // namespace metrolux
