#pragma once
#include "base/state.h"

#include <algorithm>
#include <cstdint>

namespace metrolux::core {

/// Where an iteration's light subpaths come from: chains, independent samples, or nowhere.
enum class LightSubpaths : uint8_t { Chains, Independent, None };

/// Chooses the light subpaths of the passes by what makes the least noise: chains find what is hard to find;
/// where everything is seen, independent subpaths do more than correlated ones; and where eye subpaths find
/// all light well by themselves, more of those are worth more than any light subpath.
///
/// Judged by passes of chains, the first ones and a few each time that the number of passes has grown by a
/// factor. Samples of chains say how noisy independent ones are even where those have found nothing yet
/// (LightSubpathNoise), and what eye subpaths miss (EyeTail); the converse fails: a trial of
/// independent light subpaths, or of none, looks best before its first firefly. Where independent ones are
/// better than chains and it is not clear yet whether none are better still, a few passes of them follow.
class LightSubpathChoice {
  public:
    /// `noneMayDo`: whether eye subpaths can find all light by themselves.
    explicit LightSubpathChoice(bool noneMayDo) : noneMayDo_(noneMayDo) {}

    /// Of the next pass.
    LightSubpaths next() const {
        switch (phase_) {
            case Phase::OfChains:
                return LightSubpaths::Chains;
            case Phase::OfIndependent:
                return LightSubpaths::Independent;
            case Phase::Settled:
                break;
        }
        return chosen_;
    }
    /// Whether the next pass is judged.
    bool judging() const { return phase_ != Phase::Settled; }
    bool noneMayDo() const { return noneMayDo_; }
    /// The choice before the judgement that is going on, or the present one.
    LightSubpaths chosen() const { return chosen_; }
    /// Whether half of the passes have been made that the next judgement has to go by.
    bool halfWay() const { return !judging() && passes_ == std::max(nextTrial_ / 2, settledAt_); }

    /// A pass has been made. `gain`: the noise of as many independent light subpaths over that of the chains;
    /// `lossOfNone()`: the noise of eye subpaths alone over that of the judged passes in the same time, by
    /// which none are chosen below 1. It is called where those are all made.
    template <class LossOfNone>
    void endPass(double gain, LossOfNone&& lossOfNone) {
        ++passes_;
        if (phase_ == Phase::Settled) {
            if (passes_ >= nextTrial_) phase_ = Phase::OfChains, left_ = kTrial;
            return;
        }
        if (--left_ > 0) return;
        double loss = noneMayDo_ ? lossOfNone() : 1;
        if (phase_ == Phase::OfChains) {
            better_ = gain < 1 ? LightSubpaths::Independent : LightSubpaths::Chains;
            if (noneMayDo_ && better_ == LightSubpaths::Independent) {
                // Independent ones make at least this share of the noise of the chains.
                loss /= gain;
                if (loss >= 1) {
                    phase_ = Phase::OfIndependent;
                    left_ = kTrial;
                    return;
                }
            }
        }
        chosen_ = noneMayDo_ && loss < 1 ? LightSubpaths::None : better_;
        phase_ = Phase::Settled;
        settledAt_ = passes_;
        // Passes with light subpaths cost several times as much as those without.
        while (nextTrial_ <= passes_) nextTrial_ *= chosen_ == LightSubpaths::None ? 4 : 2;
        if (loss < kClear) nextTrial_ = std::max(nextTrial_, 8 * passes_);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(passes_, nextTrial_, left_, settledAt_, phase_, better_, chosen_);
        checkState(nextTrial_ >= kFirstTrial && phase_ <= Phase::Settled && better_ <= LightSubpaths::None &&
                       chosen_ <= LightSubpaths::None,
                   "a choice of light subpaths");
    }

  private:
    enum class Phase : uint8_t { OfChains, OfIndependent, Settled };
    static constexpr uint64_t kFirst = 4, kFirstTrial = 16, kTrial = 2;
    static constexpr double kClear = 0.7;  ///< a loss of none that a second look is not likely to change
    bool noneMayDo_;
    uint64_t passes_ = 0;
    uint64_t nextTrial_ = kFirstTrial;
    uint64_t left_ = kFirst;  ///< judged passes
    uint64_t settledAt_ = 0;  ///< passes at the last choice
    Phase phase_ = Phase::OfChains;
    LightSubpaths better_ = LightSubpaths::Chains;  ///< of the two that are not none
    LightSubpaths chosen_ = LightSubpaths::Chains;
};

}  // namespace metrolux::core
