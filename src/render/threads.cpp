#include "render/threads.h"

#include "base/error.h"

#include <tbb/info.h>

#include <latch>
#include <system_error>
#include <thread>
#include <vector>

namespace metrolux::core {

namespace {

int requiredThreads(int threads) {
    const int count = threads > 0 ? threads : tbb::info::default_concurrency();
    requireThreads(count);
    return count;
}

}  // namespace

void requireThreads(int count) {
    std::vector<std::thread> threads;
    std::latch go(1);
    std::string problem;
    try {
        threads.reserve(static_cast<size_t>(count));
        for (int i = 1; i < count; ++i) threads.emplace_back([&go] { go.wait(); });
    } catch (const std::system_error& error) {
        problem = error.what();
    }
    go.count_down();
    for (std::thread& thread : threads) thread.join();
    if (!problem.empty())
        throw Error("found {} of {} threads: {}; try fewer with --threads", threads.size() + 1, count,
                    problem);
}

ThreadLimit::ThreadLimit(int threads)
    : threads_(requiredThreads(threads)),
      control_(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads_)),
      arena_(threads_) {}

Workers::Workers(int threads) : arena_(requiredThreads(threads)) {
    using Control = tbb::global_control;
    const auto wanted = static_cast<size_t>(arena_.max_concurrency());
    if (wanted > Control::active_value(Control::max_allowed_parallelism))
        more_.emplace(Control::max_allowed_parallelism, wanted);
}

}  // namespace metrolux::core
