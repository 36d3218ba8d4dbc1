#pragma once
#include "base/parallel.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <atomic>
#include <optional>

namespace metrolux::core {

/// Throws Error when the system does not give so many threads, memory or their number being limited. TBB,
/// which starts them when there is work, would end the process.
void requireThreads(int count);

/// Limits how many threads work while it lives, Embree's building of its tree included.
class ThreadLimit {
  public:
    /// 0: one thread for each core.
    explicit ThreadLimit(int threads);
    int threads() const { return threads_; }
    template <class Body>
    auto execute(Body&& body) {
        return arena_.execute(body);
    }

  private:
    int threads_;
    tbb::global_control control_;
    tbb::task_arena arena_;
};

/// Threads for the work of one of several that may be at work in a process: no limit for the others.
class Workers {
  public:
    /// 0: one thread for each core.
    explicit Workers(int threads);
    int threads() const { return arena_.max_concurrency(); }
    template <class Body>
    auto execute(Body&& body) {
        return arena_.execute(body);
    }

    /// The same, but cancel() ends it within milliseconds: then, and ever after, it throws Canceled.
    template <class Body>
    auto executeCancelable(Body&& body) {
        return arena_.execute([&] {
            if (canceled_) throw Canceled();
            std::optional<decltype(body())> result;
            tbb::task_group group(context_);
            if (group.run_and_wait([&] { result.emplace(body()); }) == tbb::canceled) throw Canceled();
            return *std::move(result);
        });
    }
    /// Any thread may call it.
    void cancel() noexcept {
        canceled_ = true;
        context_.cancel_group_execution();
    }

  private:
    std::optional<tbb::global_control> more_;  ///< than there are cores
    tbb::task_arena arena_;
    tbb::task_group_context context_;
    std::atomic<bool> canceled_{false};
};

}  // namespace metrolux::core
