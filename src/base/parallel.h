#pragma once
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <cstddef>
#include <exception>

#if defined(__SANITIZE_THREAD__)
#define METROLUX_UNDER_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define METROLUX_UNDER_THREAD_SANITIZER 1
#endif
#endif

#ifdef METROLUX_UNDER_THREAD_SANITIZER
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>
#endif

namespace metrolux::core {

/// Out of parallelFor() when its task group was canceled (Workers::cancel): some indices have not been run.
struct Canceled : std::exception {
    const char* what() const noexcept override { return "canceled"; }
};

#ifdef METROLUX_UNDER_THREAD_SANITIZER

/// The same with threads that are made for each call: the thread sanitizer does not see how the
/// distribution's TBB, which is not instrumented, hands work over, and would report all of it. So it sees
/// every access of the bodies in its true order, and nothing has to be suppressed.
template <class Body>
void parallelFor(size_t n, Body&& body) {
    std::atomic<size_t> next{0};
    std::mutex mutex;
    std::exception_ptr failure;
    const auto work = [&] {
        try {
            for (size_t i = next++; i < n; i = next++) body(i);
        } catch (...) {
            next = n;
            const std::lock_guard lock(mutex);
            if (!failure) failure = std::current_exception();
        }
    };
    {
        using Control = tbb::global_control;
        const size_t allowed = Control::active_value(Control::max_allowed_parallelism);
        const size_t hands =
            std::min({n, static_cast<size_t>(tbb::this_task_arena::max_concurrency()), allowed});
        std::vector<std::jthread> others;
        while (others.size() + 1 < hands) others.emplace_back(work);
        work();
    }
    if (failure) std::rethrow_exception(failure);
}

#else

/// Runs body(i) for i in [0, n), one task per index; results must not depend on the order.
template <class Body>
void parallelFor(size_t n, Body&& body) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, n, 1), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i != range.end(); ++i) body(i);
    });
    if (tbb::is_current_task_group_canceling()) throw Canceled();
}

#endif

}  // namespace metrolux::core
