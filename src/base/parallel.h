#pragma once
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace metrolux {

/// Runs body(i) for i in [0, n), one task per index; results must not depend on the order.
template <class Body>
void parallelFor(size_t n, Body&& body) {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, n, 1), [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i != range.end(); ++i) body(i);
    });
}

}  // namespace metrolux
