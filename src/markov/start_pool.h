#pragma once
#include "base/rng.h"
#include "base/state.h"

#include <cstddef>
#include <span>
#include <vector>

namespace metrolux::core {

/// A uniform sample that is worth remembering: the key that makes it again (uniformSample()) and its target.
struct UniformSample {
    uint64_t key = 0;
    double size = 0;
};

/// All uniform samples so far, as far as chains need them: the mean of the target F, and for each slot one
/// sample, drawn in proportion to F. A chain that starts from a slot and whose weights are multiplied by
/// mean() has no start-up bias, however few the samples are and however short the chain is: for any h, the
/// expectation of mean() * h(a sample drawn in proportion to F) is the integral of F h [Veach & Guibas 1997,
/// Metropolis Light Transport, 5.1]. That holds for the average over slots: they are drawn systematically.
class StartPool {
  public:
    explicit StartPool(size_t slots) : keys_(slots) {}

    /// Adds `drawn` uniform samples, of which `visible` are those with F > 0.
    void add(std::span<const UniformSample> visible, size_t drawn, CounterRng& rng);
    /// Forgets everything (the target has changed).
    void clear();

    size_t drawn() const { return drawn_; }
    bool empty() const { return !(sum_ > 0); }
    double mean() const { return drawn_ > 0 ? sum_ / double(drawn_) : 0; }
    double standardError() const;
    /// Key of a slot's sample; the pool may not be empty.
    uint64_t key(size_t slot) const { return keys_[slot]; }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeElements(archive, keys_, "keys");
        archive(drawn_, sum_, sumOfSquares_);
    }

  private:
    std::vector<uint64_t> keys_;
    size_t drawn_ = 0;
    double sum_ = 0, sumOfSquares_ = 0;
};

}  // namespace metrolux::core
