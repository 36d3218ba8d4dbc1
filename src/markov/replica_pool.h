#pragma once
/// Uniform samples of an iteration that are visible: they wait for the chains that they are exchanged with
/// [HJ11], and the first of them are the pool that chains start from.

#include "base/distribution.h"
#include "markov/chain.h"
#include "markov/replica_mixture.h"

#include <vector>

namespace metrolux::core {

/// The uniform samples of a lane. They are added when they have been evaluated, and taken one a step, in the
/// same order. Only visible ones are kept until then. `Value` has `bool visible() const`.
template <class Value>
class UniformQueue {
  public:
    using State = MarkovState<Value>;

    /// Begins an iteration.
    void clear() {
        forget();
        added_ = taken_ = 0;
    }
    /// Drops the samples that have been taken; their memory serves spare().
    void forget() {
        for (Waiting& w : waiting_) spare_.push_back(std::move(w.state));
        waiting_.clear();
        next_ = 0;
    }
    /// A state to evaluate the next sample into: no coordinates, weight 0, some old value.
    State spare() {
        if (spare_.empty()) return {};
        State state = std::move(spare_.back());
        spare_.pop_back();
        state.u.clear();
        state.weight = 0;
        return state;
    }
    void add(State&& sample) {
        if (sample.value.visible())
            waiting_.push_back({added_, std::move(sample)});
        else
            spare_.push_back(std::move(sample));
        ++added_;
    }

    size_t added() const { return added_; }
    /// Visible ones that are kept, taken or not.
    size_t visible() const { return waiting_.size(); }
    /// Whether all that were added have been taken.
    bool empty() const { return taken_ == added_; }
    /// Takes the next sample: its state, valid until forget(), or null if it is invisible.
    State* take() {
        const size_t sample = taken_++;
        if (next_ == waiting_.size() || waiting_[next_].sample != sample) return nullptr;
        return &waiting_[next_++].state;
    }

    /// Calls visit(state) for the visible ones that are kept.
    template <class Visit>
    void forEach(Visit&& visit) const {
        for (const Waiting& w : waiting_) visit(w.state);
    }

  private:
    struct Waiting {
        size_t sample;  ///< its number among the lane's uniform samples
        State state;
    };
    std::vector<Waiting> waiting_;
    size_t next_ = 0;  ///< the first of them that has not been taken
    size_t added_ = 0, taken_ = 0;
    std::vector<State> spare_;
};

/// Visible uniform samples of all lanes. A chain that starts from one of them, drawn in proportion to its
/// target, has no start-up bias if its weights carry the pool's mean of the target (ReplicaMixture).
template <class Value>
class ReplicaPool {
  public:
    using State = MarkovState<Value>;

    void add(const UniformQueue<Value>& samples) {
        samples.forEach([&](const State& state) { states_.push_back(&state); });
    }
    bool empty() const { return states_.empty(); }

    /// Number of the states, which is the sum of the visibility replica's target over them.
    double visible() const { return double(states_.size()); }
    /// Sum of the contribution replica's target over them.
    double sumOfSizes() const {
        double sum = 0;
        for (const State* state : states_) sum += state->value.size;
        return sum;
    }

    /// A start state for each lane, any of the pool with the same probability; `offset` in [0, 1). Drawn
    /// systematically, so that lanes get different ones where there are enough. Not for an empty pool.
    std::vector<const State*> draw(size_t lanes, double offset) const {
        std::vector<const State*> result;
        for (size_t i = 0; i < lanes; ++i) {
            const double at = (double(i) + offset) / double(lanes) * double(states_.size());
            result.push_back(states_[std::min(states_.size() - 1, static_cast<size_t>(at))]);
        }
        return result;
    }
    /// The same, in proportion to the size F.
    std::vector<const State*> drawBySize(size_t lanes, double offset) const {
        std::vector<double> sizes;
        for (const State* state : states_) sizes.push_back(state->value.size);
        const DiscreteDistribution bySize(sizes);
        std::vector<const State*> result;
        for (size_t i = 0; i < lanes; ++i) {
            float u = std::min(static_cast<float>((double(i) + offset) / double(lanes)), kOneMinusEpsilon);
            result.push_back(states_[bySize.sample(u)]);
        }
        return result;
    }

  private:
    std::vector<const State*> states_;
};

}  // namespace metrolux::core
