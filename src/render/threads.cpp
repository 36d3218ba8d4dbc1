#include "render/threads.h"

#include <tbb/info.h>

namespace metrolux::core {

ThreadLimit::ThreadLimit(int threads)
    : threads_(threads > 0 ? threads : tbb::info::default_concurrency()),
      control_(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads_)),
      arena_(threads_) {}

}  // namespace metrolux::core
