#pragma once
/// Markov chains in primary sample space and replica exchange between them. A chain sees a callable that
/// turns a stream into a value, and a target density of that value; it knows nothing of what the value means.

#include "markov/mutation.h"

#include <algorithm>
#include <utility>

namespace metrolux::core {

/// A state with the value that its primary sample evaluates to. `weight` collects the expected-value weights
/// [Kel02; Veach97] that the state has earned and that its owner has still to pay out.
template <class Value>
struct MarkovState {
    PrimarySample u;
    Value value{};
    double weight = 0;

    /// Calls pay(value, weight) for a weight that is not 0, which is then paid.
    template <class Pay>
    void payOut(Pay&& pay) {
        if (weight > 0) pay(value, weight);
        weight = 0;
    }
};

/// The target of visibility-driven chains [HJ11], of values that have `bool visible() const`.
struct VisibilityTarget {
    template <class Value>
    double operator()(const Value& v) const {
        return v.visible() ? 1.0 : 0.0;
    }
};

/// Evaluates a uniform sample whose coordinates are the numbers of CounterRng(key): the key makes it again.
template <class Value, class Evaluate>
void uniformSample(Evaluate&& evaluate, MarkovState<Value>& state, uint64_t key) {
    state.u.clear();
    state.weight = 0;
    CounterRng rng(key);
    PrimarySampleStream stream(state.u, rng);
    evaluate(stream, state.value);
}

/// Reads the mutation `to` of the sample `from`. Where it needs coordinates that `from` has not, both get
/// them: a uniform one and its mutation. `from` keeps its own if it remains the chain's state, because the
/// rejection depended on it. Were it drawn anew each time, bright spots in such coordinates would be too
/// bright: a chain that has left one would find its way back by coordinates that it keeps, and a chain that
/// has failed to enter one would forget that.
class MutatedStream final : public SampleStream {
  public:
    MutatedStream(PrimarySample& from, PrimarySample& to, const MutationKernel& kernel, CounterRng& rng)
        : from_(from), to_(to), kernel_(kernel), rng_(rng) {}
    void seek(int block) override { position_ = static_cast<size_t>(blockOffset(block)); }
    float next1D() override {
        while (position_ >= to_.size()) {
            from_.push_back(rng_.next1D());
            to_.push_back(kernel_.mutated(from_.back(), rng_));
        }
        return to_[position_++];
    }
    Vec2f next2D() override {
        const float x = next1D();
        return {x, next1D()};
    }
    void skip(int count) override { position_ += static_cast<size_t>(count); }

  private:
    PrimarySample &from_, &to_;
    const MutationKernel& kernel_;
    CounterRng& rng_;
    size_t position_ = 0;
};

/// Metropolis-Hastings with a symmetric kernel. `Target` is callable: double(const Value&), not negative.
template <class Value, class Target>
class MarkovChain {
  public:
    MarkovChain(Target target, MutationKernel::Kind kind, uint64_t adaptations = MutationKernel::kAlways)
        : kernel_(kind, adaptations), target_(std::move(target)) {}

    MarkovState<Value>& state() { return state_; }
    const MarkovState<Value>& state() const { return state_; }
    const MutationKernel& kernel() const { return kernel_; }
    MutationKernel& kernel() { return kernel_; }
    double target(const Value& value) const { return target_(value); }

    /// Evaluates a mutation of the current state into `proposal` (whose weight is reset) and returns the
    /// probability min(1, target' / target) with which it should be accepted. `evaluate(stream, value)` fills
    /// the value.
    template <class Evaluate>
    double propose(Evaluate&& evaluate, MarkovState<Value>& proposal, CounterRng& rng) {
        MutatedStream stream = mutate(proposal, rng);
        evaluate(stream, proposal.value);
        return acceptance(proposal);
    }

    /// propose() in parts: makes a mutation of the current state, whose value is to be evaluated from the
    /// stream, then acceptance(). The chain's state, the proposal and `rng` must stay where they are until
    /// then.
    MutatedStream mutate(MarkovState<Value>& proposal, CounterRng& rng) {
        kernel_.mutate(state_.u, proposal.u, rng);
        proposal.weight = 0;
        return {state_.u, proposal.u, kernel_, rng};
    }
    double acceptance(const MarkovState<Value>& proposal) const {
        const double now = target_(state_.value), then = target_(proposal.value);
        return now > 0 ? std::min(1.0, then / now) : (then > 0 ? 1.0 : 0.0);
    }

    /// As propose() with an independent uniform sample in place of a mutation (the large step of [Kel02]):
    /// the one of stream `key`, see uniformSample().
    template <class Evaluate>
    double proposeUniform(Evaluate&& evaluate, MarkovState<Value>& proposal, uint64_t key) {
        uniformSample(evaluate, proposal, key);
        return acceptance(proposal);
    }

    /// Decides about the proposal. On acceptance the two states are exchanged: `proposal` then holds the old
    /// one. `mutated`: the proposal is a mutation, whose step the kernel adapts.
    bool decide(double acceptance, MarkovState<Value>& proposal, CounterRng& rng, bool mutated = true) {
        const bool accepted = rng.nextDouble() < acceptance;
        if (accepted) std::swap(state_, proposal);
        if (mutated) kernel_.adapt(accepted);
        return accepted;
    }

    /// Kernel and primary sample. The value and its weight are the owner's: it pays out weights before it
    /// saves, and saves the value too or evaluates it again.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(kernel_);
        serializeSample(archive, state_.u);
    }

  private:
    MutationKernel kernel_;
    Target target_;
    MarkovState<Value> state_;
};

/// Replica exchange: swaps the states of two chains with probability min(1, a(y) b(x) / (a(x) b(y))) for
/// states x of a and y of b. Each chain's marginal stays what it was.
template <class Value, class TargetA, class TargetB>
bool exchangeReplicas(MarkovChain<Value, TargetA>& a, MarkovChain<Value, TargetB>& b, CounterRng& rng) {
    const Value &x = a.state().value, &y = b.state().value;
    const double now = a.target(x) * b.target(y), then = a.target(y) * b.target(x);
    const double probability = now > 0 ? std::min(1.0, then / now) : (then > 0 ? 1.0 : 0.0);
    if (!(rng.nextDouble() < probability)) return false;
    std::swap(a.state(), b.state());
    return true;
}

}  // namespace metrolux::core
