#include "markov/start_pool.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace metrolux::core {

void StartPool::add(std::span<const UniformSample> visible, size_t drawn, CounterRng& rng) {
    drawn_ += drawn;
    double batch = 0;
    for (const UniformSample& s : visible) {
        batch += s.size;
        sumOfSquares_ += s.size * s.size;
    }
    if (!(batch > 0)) return;
    sum_ += batch;
    // Weighted reservoir sampling: a slot changes to the batch with the batch's share of all.
    const double share = batch / sum_, offset = rng.nextDouble(), slots = double(keys_.size());
    size_t i = 0;
    double passed = visible[0].size;
    for (size_t slot = 0; slot < keys_.size(); ++slot) {
        const double threshold = (double(slot) + offset) / slots * batch;
        while (passed < threshold && i + 1 < visible.size()) passed += visible[++i].size;
        if (rng.nextDouble() < share) keys_[slot] = visible[i].key;
    }
}

void StartPool::clear() {
    drawn_ = 0;
    sum_ = sumOfSquares_ = 0;
}

double StartPool::standardError() const {
    if (drawn_ < 2) return std::numeric_limits<double>::infinity();
    const double n = double(drawn_), m = mean();
    return std::sqrt(std::max(0.0, sumOfSquares_ / n - m * m) / (n - 1));
}

}  // namespace metrolux::core
