#pragma once
#include "base/rng.h"
#include "base/state.h"
#include "sampling/sample_stream.h"

#include <algorithm>
#include <vector>

namespace metrolux::core {

/// A point of primary sample space: the coordinates that have been asked for so far.
using PrimarySample = std::vector<float>;

template <class Archive>
void serializeSample(Archive& archive, PrimarySample& u) {
    archive(u);
    const auto valid = [](float x) { return x >= 0 && x <= kOneMinusEpsilon; };
    checkState(std::all_of(u.begin(), u.end(), valid), "primary samples in [0, 1)");
}

/// Reads a PrimarySample; coordinates beyond its end are drawn uniformly and appended. For samples that are
/// no mutations: nothing has depended on such coordinates yet, so that they are uniform. MutatedStream reads
/// mutations.
class PrimarySampleStream final : public SampleStream {
  public:
    PrimarySampleStream(PrimarySample& u, CounterRng& rng) : u_(u), rng_(rng) {}
    void seek(int block) override { position_ = static_cast<size_t>(blockOffset(block)); }
    float next1D() override {
        while (position_ >= u_.size()) u_.push_back(rng_.next1D());
        return u_[position_++];
    }
    Vec2f next2D() override {
        const float x = next1D();
        return {x, next1D()};
    }
    void skip(int count) override { position_ += static_cast<size_t>(count); }

  private:
    PrimarySample& u_;
    CounterRng& rng_;
    size_t position_ = 0;
};

}  // namespace metrolux::core
