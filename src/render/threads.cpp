#include "render/threads.h"

#include <tbb/info.h>

namespace metrolux::core {

ThreadLimit::ThreadLimit(int threads)
    : threads_(threads > 0 ? threads : tbb::info::default_concurrency()),
      control_(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads_)),
      arena_(threads_) {}

Workers::Workers(int threads) : arena_(threads > 0 ? threads : tbb::info::default_concurrency()) {
    using Control = tbb::global_control;
    const auto wanted = static_cast<size_t>(arena_.max_concurrency());
    if (wanted > Control::active_value(Control::max_allowed_parallelism))
        more_.emplace(Control::max_allowed_parallelism, wanted);
}

}  // namespace metrolux::core
