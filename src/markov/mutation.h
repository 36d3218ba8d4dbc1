#pragma once
#include "base/rng.h"
#include "base/state.h"
#include "markov/primary_sample.h"

#include <limits>
#include <vector>

namespace metrolux::core {

/// Symmetric mutation of every coordinate, with wrap-around.
class MutationKernel {
  public:
    enum class Kind {
        Adaptive,  ///< supplement eq. 4-5, [HJ11]: step (2 xi)^(1/theta), theta steered to the goal
                   ///< acceptance
        Kelemen    ///< [Kel02]: step between 1/1024 and 1/64, log-uniform, not adapted
    };
    static constexpr double kGoalAcceptance = 0.234;
    /// theta is kept in this range: 1 is the uniform jump, at 0.02 the median step is 2^-50 and the chain
    /// stands still.
    static constexpr double kMinimalTheta = 0.02, kMaximalTheta = 1.0;

    static constexpr uint64_t kAlways = std::numeric_limits<uint64_t>::max();

    /// theta adapts to the first `adaptations` decisions. While it does, the chain has another distribution
    /// than its target: where it stays it learns small steps, and stays longer. How much, falls as one over
    /// their number.
    explicit MutationKernel(Kind kind = Kind::Adaptive, uint64_t adaptations = kAlways)
        : kind_(kind), adaptations_(adaptations) {}

    /// The mutated coordinate x.
    float mutated(float x, CounterRng& rng) const;
    /// Writes the mutated copy of `from` to `to`.
    void mutate(const PrimarySample& from, PrimarySample& to, CounterRng& rng) const;
    /// Eq. 5, after each decision.
    void adapt(bool accepted);
    /// theta will not change any more.
    bool settled() const { return kind_ != Kind::Adaptive || tried_ >= adaptations_; }

    /// Gives all of them the mean theta.
    static void shareTheta(const std::vector<MutationKernel*>& kernels);

    double theta() const { return theta_; }
    uint64_t tried() const { return tried_; }
    uint64_t accepted() const { return accepted_; }
    double acceptance() const { return tried_ ? double(accepted_) / double(tried_) : 0.0; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(theta_, tried_, accepted_);
        checkState(theta_ >= kMinimalTheta && theta_ <= kMaximalTheta, "a theta within its limits");
    }

  private:
    Kind kind_;
    uint64_t adaptations_;
    double theta_ = kMaximalTheta;
    uint64_t tried_ = 0, accepted_ = 0;
};

/// x + step on the circle [0, 1).
inline float wrapUnit(float x) {
    x -= std::floor(x);
    return std::min(x, kOneMinusEpsilon);
}

}  // namespace metrolux::core
