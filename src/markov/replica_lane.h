#pragma once
/// One lane of replicas: its chains, its random numbers, and what they do in a step.

#include "markov/replica_pool.h"
#include "markov/replica_settings.h"
#include "markov/split_estimator.h"
#include "sampling/streams.h"

#include <optional>
#include <span>

namespace metrolux::core {

/// A value that is to be made from its stream.
template <class Value>
struct Evaluation {
    SampleStream* stream;
    Value* value;
};

/// `Value` and the `Model` of its functions are those of ReplicaLanes.
///
/// Weights: uniform samples have theirs from the mixture; the visibility chain's state earns the weight of
/// one sample in each step in which it stays; the contribution chain's state and its proposal share that of
/// one in proportion to the acceptance [Kel02, section 3.2]. A state is paid when a chain leaves it, and at
/// the end of an iteration.
template <class Value>
class ReplicaLane {
  public:
    using State = MarkovState<Value>;

    ReplicaLane(const ReplicaSettings& settings, int index, Normalization::Samples samples)
        : index_(static_cast<size_t>(index)),
          measuredSplit_(settings.measuredSplit),
          rng_(hashKey(settings.seed, StreamPurpose::Chain, index)),
          visibility_(VisibilityTarget{}, settings.kernel),
          contribution_(ContributionTarget{}, settings.kernel),
          samples_(std::move(samples)) {}

    /// Begins an iteration.
    void begin() {
        uniform_.clear();
        squares_ = {};
    }

    const UniformQueue<Value>& uniform() const { return uniform_; }
    MutationKernel& visibilityKernel() { return visibility_.kernel(); }
    MutationKernel& contributionKernel() { return contribution_.kernel(); }
    Normalization::Samples& samples() { return samples_; }
    const SplitEstimator::Squares& squares() const { return squares_; }

    void start(const State& visibility, const State& contribution) {
        visibility_.state() = visibility;
        contribution_.state() = contribution;
    }

    /// Takes uniform samples until there are `end` of them. Invisible ones are paid at once, visible ones
    /// are queued until the chains come to them.
    template <class Model>
    void addUniform(Model& model, const ReplicaMixture& mix, size_t end) {
        while (uniform_.added() < end) addBatch(model, mix, std::min(kUniformBatch, end - uniform_.added()));
    }

    /// The step's uniform sample, one of `all` in the iteration. `exchange`: the visibility replica moves in
    /// this step too, and a visible sample becomes its state, which is then its move.
    template <class Model>
    void uniformStep(Model& model, const ReplicaMixture& mix, size_t all, bool exchange) {
        if (uniform_.empty()) {
            uniform_.forget();
            addBatch(model, mix, std::min(kUniformBatch, all - uniform_.added()));
        }
        State* u = uniform_.take();
        if (!u) return;
        u->weight = mix.uniformWeight(u->value.size);
        squares_.add(SplitEstimator::Uniform, square(u->value, mix));
        if (!exchange) return payOut(model, *u);
        // Exchange with the visibility replica is certain for a visible sample [HJ11].
        payOut(model, visibility_.state());
        std::swap(*u, visibility_.state());
        ++uniformSwaps_;
        exchanged_ = true;
    }

    /// Appends the mutations that wait for their evaluation in this step.
    void propose(bool visibility, bool contribution, std::vector<Evaluation<Value>>& evaluations) {
        if (visibility && !exchanged_) evaluations.push_back(forVisibility_.mutate(visibility_, rng_));
        if (contribution) evaluations.push_back(forContribution_.mutate(contribution_, rng_));
    }

    /// The chains' moves when the mutations have been evaluated.
    template <class Model>
    void visibilityStep(Model& model, const ReplicaMixture& mix) {
        if (!exchanged_) {
            State& proposal = forVisibility_.state;
            const double a = visibility_.acceptance(proposal);
            if (visibility_.decide(a, proposal, rng_)) payOut(model, proposal);
        }
        exchanged_ = false;
        State& v = visibility_.state();
        v.weight += mix.visibilityWeight(v.value.size);
        squares_.add(SplitEstimator::Visibility, square(v.value, mix));
        if (v.value.visible()) samples_.addVisibility(v.value.size);
    }
    /// These samples enter the normalizations by Bennett's ratio only.
    template <class Model>
    void contributionStep(Model& model, const ReplicaMixture& mix) {
        State& proposal = forContribution_.state;
        State& now = contribution_.state();
        const double a = contribution_.acceptance(proposal);
        proposal.weight = a * mix.contributionWeight(proposal.value.size);
        now.weight += (1.0 - a) * mix.contributionWeight(now.value.size);
        squares_.add(SplitEstimator::Contribution,
                     a * square(proposal.value, mix) + (1.0 - a) * square(now.value, mix));
        contribution_.decide(a, proposal, rng_);
        payOut(model, proposal);  // the one of the two that the chain has left
        samples_.addContribution(now.value.size);
        if (mix.visibility > 0 && visibility_.state().value.visible()) {
            ++swapsTried_;
            swapsMade_ += exchangeReplicas(visibility_, contribution_, rng_);
        }
    }

    /// Pays the states that the chains are in: the end of an iteration.
    template <class Model>
    void finish(Model& model) {
        payOut(model, visibility_.state());
        payOut(model, contribution_.state());
    }

    /// Adds the lane's counts, as one of `lanes`.
    void addTo(ReplicaCounts& counts, size_t lanes) const {
        const auto add = [&](const MutationKernel& kernel, ReplicaCounts::Acceptance& a) {
            a.tried += kernel.tried();
            a.accepted += kernel.accepted();
            a.theta += kernel.theta() / double(lanes);
        };
        add(visibility_.kernel(), counts.visibility);
        add(contribution_.kernel(), counts.contribution);
        counts.swapsTried += swapsTried_;
        counts.swapsMade += swapsMade_;
        counts.uniformSwaps += uniformSwaps_;
    }

    /// Between two iterations.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(rng_, visibility_, contribution_, swapsTried_, swapsMade_, uniformSwaps_);
    }

  private:
    struct ContributionTarget {
        double operator()(const Value& v) const { return v.size; }
    };
    /// A mutation, kept for its memory, and the stream that it is evaluated from.
    struct Proposal {
        State state;
        std::optional<MutatedStream> stream;
        template <class Chain>
        Evaluation<Value> mutate(Chain& chain, CounterRng& rng) {
            return {&stream.emplace(chain.mutate(state, rng)), &state.value};
        }
    };

    /// Uniform samples that are evaluated together.
    static constexpr size_t kUniformBatch = 64;

    template <class Model>
    void payOut(Model& model, State& state) {
        state.payOut([&](Value& value, double weight) { model.pay(index_, value, weight); });
    }

    template <class Model>
    void addBatch(Model& model, const ReplicaMixture& mix, size_t count) {
        std::vector<State> states(count);
        std::vector<PrimarySampleStream> streams;
        std::vector<Evaluation<Value>> evaluations;
        streams.reserve(count);
        for (size_t i = 0; i < count; ++i) {
            State& state = states[i] = uniform_.spare();
            model.startUniform(state.u, rng_, index_, uniform_.added() + i);
            evaluations.push_back({&streams.emplace_back(state.u, rng_), &state.value});
        }
        model.evaluateUniform(std::span<const Evaluation<Value>>(evaluations));
        for (State& state : states) {
            samples_.addUniform(state.value.size);
            if (!state.value.visible()) {
                squares_.add(SplitEstimator::Uniform, 0);
                state.weight = mix.invisibleWeight;
                payOut(model, state);
            }
            uniform_.add(std::move(state));
        }
    }

    /// The square of what a value contributes with its weight in the mixture, where the split asks for it.
    double square(const Value& value, const ReplicaMixture& mix) const {
        if (!measuredSplit_) return 0;
        double squares = value.size * value.size;
        if constexpr (requires { value.squares; }) squares = value.squares;
        const double weight = mix.uniformWeight(value.size);
        return weight * weight * squares;
    }

    size_t index_;
    bool measuredSplit_;
    CounterRng rng_;
    MarkovChain<Value, VisibilityTarget> visibility_;
    MarkovChain<Value, ContributionTarget> contribution_;
    UniformQueue<Value> uniform_;
    Proposal forVisibility_, forContribution_;
    bool exchanged_ = false;  ///< the visibility replica has received a uniform sample in this step
    uint64_t swapsTried_ = 0, swapsMade_ = 0, uniformSwaps_ = 0;
    Normalization::Samples samples_;
    SplitEstimator::Squares squares_;
};

}  // namespace metrolux::core
