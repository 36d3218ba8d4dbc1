#pragma once
#include "base/state.h"

#include <cstdint>

namespace metrolux::core {

/// Whether an iteration's light subpaths come from chains or are independent: whatever makes less noise in
/// the same number. Chains find what is hard to find; where everything is seen, independent subpaths do more
/// than correlated ones.
///
/// Judged by passes of chains, the first ones and two each time that the number of passes has doubled
/// (MixtureDensity::ofNoise(): as many independent light subpaths would make the noise of these). Samples of
/// chains say how noisy independent ones are even where those have found nothing yet; the converse fails: a
/// trial of independent light subpaths looks best before their first firefly.
class ChainChoice {
  public:
    /// Whether the next pass is one of chains.
    bool chains() const { return judging() || better_; }
    /// Whether the next pass is judged.
    bool judging() const { return passes_ < kFirst || passes_ >= nextTrial_; }

    /// A pass has been made. `gain`: the noise of as many independent light subpaths over that of the chains.
    void endPass(double gain) {
        if (judging()) better_ = !(gain < 1);
        ++passes_;
        if (passes_ >= nextTrial_ + kTrial) nextTrial_ = 2 * nextTrial_;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(passes_, nextTrial_, better_);
        checkState(nextTrial_ >= kFirstTrial, "a number of passes after which chains are tried again");
    }

  private:
    static constexpr uint64_t kFirst = 4, kFirstTrial = 16, kTrial = 2;
    uint64_t passes_ = 0;
    uint64_t nextTrial_ = kFirstTrial;
    bool better_ = true;
};

}  // namespace metrolux::core
