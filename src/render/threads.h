#pragma once
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace metrolux::core {

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

}  // namespace metrolux::core
