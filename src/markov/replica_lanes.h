#pragma once
/// The replicas of docs/explain/algorithm.md section 3 (uniform, visibility, contribution) in independent
/// lanes, with replica exchange and expected-value weights. Like the chains, it knows nothing of what a value
/// means.

#include "base/distribution.h"
#include "base/parallel.h"
#include "markov/chain.h"
#include "markov/normalization.h"
#include "markov/replica_mixture.h"
#include "markov/split_estimator.h"
#include "sampling/streams.h"

#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <optional>
#include <span>

namespace metrolux::core {

struct ReplicaSettings {
    uint64_t seed = 0;
    MutationKernel::Kind kernel = MutationKernel::Kind::Adaptive;
    double inefficiency = 1;  ///< ReplicaMixture::inefficiency
    int lanes = 1;
    bool uniform = true, visibility = true, contribution = true;  ///< replicas that take part
    /// n_U : n_V : n_F, positive; those of replicas that do not take part are ignored.
    std::array<double, 3> split{1, 1, 1};
    bool measuredSplit = false;  ///< SplitEstimator goes on from `split`
    NormalizationMethod normalization = NormalizationMethod::Pooled;
    bool pooledTheta = false;  ///< lanes share theta of the adaptive kernel after each iteration
    /// The same with 0 for those that do not take part.
    std::array<double, 3> splitInUse() const {
        return {uniform ? split[0] : 0, visibility ? split[1] : 0, contribution ? split[2] : 0};
    }
};

/// What the lanes have done so far.
struct ReplicaCounts {
    struct Acceptance {
        uint64_t tried = 0, accepted = 0;
        double theta = 0;  ///< mean over the lanes
        double rate() const { return tried ? double(accepted) / double(tried) : 0; }
    };
    Acceptance visibility, contribution;
    uint64_t swapsTried = 0, swapsMade = 0;  ///< visibility with contribution
    uint64_t uniformSwaps = 0;               ///< uniform with visibility
    uint64_t replaced = 0;                   ///< states that had become invisible
};

/// A value that is to be made from its stream.
template <class Value>
struct Evaluation {
    SampleStream* stream;
    Value* value;
};

/// A fixed number of lanes, each with its own chains, adaptation and random numbers, that live across
/// iterations. `Value` has `double size` (F), `bool visible() const`, and may have `double squares`, the
/// noise that it brings, for the measured split (F^2 without). A `Model` joins them with transport:
///
///     void startUniform(PrimarySample& u, CounterRng&, size_t lane, size_t step)
///     void evaluateUniform(std::span<const Evaluation<Value>>)
///     void evaluate(std::span<const Evaluation<Value>>)
///     void pay(size_t lane, Value&, double weight)
///
/// startUniform() appends coordinates to begin with; pay() adds what the value contributes, with its weight.
/// Its calls come from many threads, those of a lane from one. evaluateUniform() gets samples of one lane,
/// evaluate() proposals of as many lanes as are run together, which depends on the number of threads: what it
/// makes of a stream must not depend on the others.
template <class Value>
class ReplicaLanes {
  public:
    using State = MarkovState<Value>;

    explicit ReplicaLanes(const ReplicaSettings& settings)
        : settings_(settings), normalization_(settings.normalization), split_(settings.splitInUse()) {
        for (int i = 0; i < settings.lanes; ++i) {
            lanes_.emplace_back(settings.seed, i, settings.kernel);
            lanes_.back().samples = normalization_.newSamples();
        }
    }

    const ReplicaSettings& settings() const { return settings_; }
    size_t size() const { return lanes_.size(); }
    Normalization& normalization() { return normalization_; }
    const Normalization& normalization() const { return normalization_; }

    /// Counts and normalizations of an iteration of about so many samples; each lane takes its part of every
    /// replica in use. Without `chains`: uniform samples alone.
    ReplicaMixture mixture(size_t samples, bool chains = true) const {
        ReplicaMixture mix;
        mix.bVisibility = normalization_.visibility();
        mix.bContribution = normalization_.contribution();
        mix.inefficiency = settings_.inefficiency;
        const std::array<double, 3> parts = chains ? split() : std::array<double, 3>{1, 0, 0};
        const auto count = [&](double part) {  // the same number in every lane
            if (!(part > 0)) return 0.0;
            const double lanes = double(lanes_.size()),
                         n = std::floor(part * double(samples) / (parts[0] + parts[1] + parts[2]));
            return std::max(1.0, std::ceil(n / lanes)) * lanes;
        };
        mix.uniform = count(parts[0]);
        mix.visibility = count(parts[1]);
        mix.contribution = count(parts[2]);
        return mix;
    }

    /// Parts of the replicas in the next iteration's samples.
    const std::array<double, 3>& split() const { return split_.split(); }

    /// Samples of an iteration that were taken elsewhere, uniform ones of these sizes. Shared out among the
    /// lanes, so that the jackknife over lanes covers them.
    void addUniform(const std::vector<double>& sizes) {
        for (size_t i = 0; i < sizes.size(); ++i) lanes_[i % lanes_.size()].samples.addUniform(sizes[i]);
    }

    /// Gives each lane's chains states to go on from; they are evaluated by the next run().
    template <class StateOf>
    void seed(StateOf&& stateOf) {
        for (Lane& lane : lanes_) {
            stateOf(lane.visibility.state().u, lane.contribution.state().u);
            lane.lastVisible = lane.visibility.state().u;
        }
    }

    /// All samples of an iteration; the scales of `mix` are set. `pass` and `first` name the iteration.
    template <class Model>
    void run(Model& model, ReplicaMixture& mix, uint32_t pass, size_t first) {
        // Decided by what is expected, not by what is found: a choice by the samples themselves would bias
        // them.
        const bool pooled = mix.uniform * mix.bVisibility >= kSmallestPool;
        sawChains_ = true;
        for (Lane& lane : lanes_) lane.begin();
        if (pooled) {
            const size_t taken = takePool(model, mix);
            startChains(model, pass, first, double(taken * lanes_.size()), mix);
        } else {
            renewStates(model);
        }
        // Lanes of a group take turns at each step, so that their proposals are evaluated side by side.
        const auto threads = static_cast<size_t>(tbb::this_task_arena::max_concurrency());
        const size_t group =
            std::clamp<size_t>(lanes_.size() / (kGroupsPerThread * threads), 1, kLargestGroup);
        parallelFor((lanes_.size() + group - 1) / group, [&](size_t i) {
            runLanes(model, i * group, std::min(lanes_.size(), (i + 1) * group), mix);
        });
    }

    /// Closes the iteration, made with this squared radius.
    void endIteration(double squaredRadius) {
        for (size_t i = 0; i < lanes_.size(); ++i) {
            normalization_.add(static_cast<int>(i), lanes_[i].samples);
            lanes_[i].samples.clear();
        }
        normalization_.endIteration(squaredRadius);
        if (settings_.pooledTheta) shareTheta();
        if (settings_.measuredSplit && sawChains_) {
            for (Lane& lane : lanes_) split_.add(lane.squares);
            split_.endIteration(settings_.inefficiency);
        }
        sawChains_ = false;
    }

    /// Between two iterations, when all weights have been paid. Values are evaluated again by run().
    template <class Archive>
    void serialize(Archive& archive) {
        serializeElements(archive, lanes_, "lanes");
        archive(normalization_, split_);
    }

    ReplicaCounts counts() const {
        ReplicaCounts c;
        for (const Lane& lane : lanes_) {
            addAcceptance(lane.visibility.kernel(), c.visibility);
            addAcceptance(lane.contribution.kernel(), c.contribution);
            c.swapsTried += lane.swapsTried;
            c.swapsMade += lane.swapsMade;
            c.uniformSwaps += lane.uniformSwaps;
            c.replaced += lane.replaced;
        }
        return c;
    }

  private:
    struct VisibilityTarget {
        double operator()(const Value& v) const { return v.visible() ? 1.0 : 0.0; }
    };
    struct ContributionTarget {
        double operator()(const Value& v) const { return v.size; }
    };

    /// Visible states that an iteration's chains are chosen from, at most. Their mean F enters the image as a
    /// factor.
    static constexpr size_t kPoolSize = 16384;
    /// With fewer visible uniform samples expected in an iteration, chains go on from the last one's states.
    static constexpr double kSmallestPool = 4;

    /// Uniform samples of a lane that are taken together, when the pool is used up.
    static constexpr size_t kUniformBatch = 64;
    /// More groups than threads, because they are never equally fast.
    static constexpr size_t kGroupsPerThread = 4, kLargestGroup = 8;

    struct Lane {
        Lane(uint64_t seed, int index, MutationKernel::Kind kind)
            : rng(hashKey(seed, StreamPurpose::Chain, index)),
              visibility(VisibilityTarget{}, kind),
              contribution(ContributionTarget{}, kind) {}

        CounterRng rng;
        MarkovChain<Value, VisibilityTarget> visibility;
        MarkovChain<Value, ContributionTarget> contribution;
        /// A visible uniform sample that was taken before the chains came to it.
        struct Ahead {
            size_t sample;  ///< its number among the lane's uniform samples
            State state;
        };
        std::vector<Ahead> ahead;
        size_t nextAhead = 0;      ///< the first that the chains have not come to
        size_t taken = 0;          ///< uniform samples of the iteration, so far
        size_t passed = 0;         ///< of them, those that the chains have come to
        std::vector<State> spare;  ///< used up, kept for their memory
        State takeSpare() {
            if (spare.empty()) return {};
            State state = std::move(spare.back());
            spare.pop_back();
            return state;
        }
        /// Forgets what has been taken ahead.
        void discardAhead() {
            for (Ahead& a : ahead) spare.push_back(std::move(a.state));
            ahead.clear();
            nextAhead = 0;
        }
        /// An iteration.
        void begin() {
            discardAhead();
            taken = passed = 0;
            squares = {};
        }
        PrimarySample lastVisible;  ///< last visible uniform sample: replaces a state that became invisible
        /// Proposal of a chain, kept for its memory, and the stream that it is evaluated from.
        struct Proposal {
            State state;
            std::optional<MutatedStream> stream;
        };
        Proposal forVisibility, forContribution;
        bool fresh = false;  ///< the visibility replica has received a uniform sample in this step
        uint64_t swapsTried = 0, swapsMade = 0, uniformSwaps = 0, replaced = 0;
        Normalization::Samples samples;
        SplitEstimator::Squares squares;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(rng, visibility, contribution, swapsTried, swapsMade, uniformSwaps, replaced);
            serializeSample(archive, lastVisible);
        }
    };

    /// The square of what a value contributes with its weight in the mixture, where the split asks for it.
    double square(const Value& value, const ReplicaMixture& mix) const {
        if (!settings_.measuredSplit) return 0;
        double squares = value.size * value.size;
        if constexpr (requires { value.squares; }) squares = value.squares;
        const double weight = mix.uniformWeight(value.size);
        return weight * weight * squares;
    }

    void shareTheta() {
        std::vector<MutationKernel*> visibility, contribution;
        for (Lane& lane : lanes_) {
            visibility.push_back(&lane.visibility.kernel());
            contribution.push_back(&lane.contribution.kernel());
        }
        MutationKernel::shareTheta(visibility);
        MutationKernel::shareTheta(contribution);
    }

    void addAcceptance(const MutationKernel& kernel, ReplicaCounts::Acceptance& a) const {
        a.tried += kernel.tried();
        a.accepted += kernel.accepted();
        a.theta += kernel.theta() / double(lanes_.size());
    }

    /// Adds what a state contributes with the weight that it has earned.
    template <class Model>
    static void payOut(Model& model, size_t lane, State& state) {
        if (state.weight > 0) model.pay(lane, state.value, state.weight);
        state.weight = 0;
    }

    /// A lane's part of a replica's samples.
    size_t samplesOfLane(double count) const { return static_cast<size_t>(count) / lanes_.size(); }

    /// Takes the lane's uniform samples up to number `end`. Invisible ones are done with, visible ones are
    /// kept until the chains come to them.
    template <class Model>
    void takeUniform(Model& model, size_t index, size_t end, const ReplicaMixture& mix) {
        Lane& lane = lanes_[index];
        std::vector<State> states(end - lane.taken);
        std::vector<PrimarySampleStream> streams;
        std::vector<Evaluation<Value>> evaluations;
        streams.reserve(states.size());
        for (size_t i = 0; i < states.size(); ++i) {
            State& state = states[i] = lane.takeSpare();
            state.u.clear();
            state.weight = 0;
            model.startUniform(state.u, lane.rng, index, lane.taken + i);
            evaluations.push_back({&streams.emplace_back(state.u, lane.rng), &state.value});
        }
        model.evaluateUniform(std::span<const Evaluation<Value>>(evaluations));
        for (State& state : states) {
            const size_t sample = lane.taken++;
            lane.samples.addUniform(state.value.size);
            if (state.value.visible()) {
                lane.lastVisible = state.u;
                lane.ahead.push_back({sample, std::move(state)});
                continue;
            }
            state.weight = mix.invisibleWeight;
            lane.squares.add(SplitEstimator::Uniform, 0);
            payOut(model, index, state);
            lane.spare.push_back(std::move(state));
        }
    }

    /// Takes the first of the iteration's uniform samples, until enough are visible to start the chains from.
    /// Returns how many a lane has taken.
    template <class Model>
    size_t takePool(Model& model, const ReplicaMixture& mix) {
        size_t taken = 0, visible = 0;
        const size_t samples = samplesOfLane(mix.uniform),
                     round = std::max<size_t>(1, kPoolSize / lanes_.size());
        while (taken < samples && visible < kPoolSize) {
            const size_t end = std::min(samples, taken + round);
            parallelFor(lanes_.size(), [&](size_t i) {
                while (lanes_[i].taken < end)
                    takeUniform(model, i, std::min(end, lanes_[i].taken + kUniformBatch), mix);
            });
            taken = end;
            visible = 0;
            for (const Lane& lane : lanes_) visible += lane.ahead.size();
        }
        return taken;
    }

    /// The targets are new in each iteration. Chains start from visible uniform samples of this iteration:
    /// any of them for the visibility replica, chosen in proportion to F for the contribution replica, with
    /// the scales that make such a start unbiased (ReplicaMixture). Going on from the last iteration's states
    /// made short chains up to 9 % too bright (white sphere in glass, 32x32 pixels); the same start without
    /// the scales made them 1.2 % too dark where F has heavy tails (veach-mis, 64x48).
    template <class Model>
    void startChains(Model& model, uint32_t pass, size_t first, double taken, ReplicaMixture& mix) {
        std::vector<const State*> pool;
        std::vector<double> sizes;
        for (const Lane& lane : lanes_)
            for (const auto& a : lane.ahead) {
                pool.push_back(&a.state);
                sizes.push_back(a.state.value.size);
            }
        double sum = 0;
        for (const double size : sizes) sum += size;
        mix.visibilityScale = double(pool.size()) / (taken * mix.bVisibility);
        mix.contributionScale = sum / (taken * mix.bContribution);
        if (pool.empty()) {  // both scales are 0: what the chains find does not count
            renewStates(model);
            return;
        }
        const DiscreteDistribution bySize(sizes);
        CounterRng rng(hashKey(settings_.seed, StreamPurpose::Replacement, pass, first));
        const double lanes = double(lanes_.size()), offsetV = rng.nextDouble(), offsetF = rng.nextDouble();
        for (size_t i = 0; i < lanes_.size(); ++i) {
            const size_t v =
                std::min(pool.size() - 1, size_t((double(i) + offsetV) / lanes * double(pool.size())));
            float u = std::min(static_cast<float>((double(i) + offsetF) / lanes), kOneMinusEpsilon);
            lanes_[i].visibility.state() = *pool[v];
            lanes_[i].contribution.state() = *pool[bySize.sample(u)];
        }
    }

    /// What is visible is too rare for startChains(): chains keep what they have found. Every state is
    /// evaluated again; one that has become invisible is replaced by a visible uniform sample: the last one
    /// that the lane has seen, or a fresh one. Resampling the lanes by new / old target was tried: it cannot
    /// reach what was invisible before, so that short chains gathered where light is always visible and b_F
    /// ran away (door-ajar, +30 %).
    template <class Model>
    void renewStates(Model& model) {
        constexpr int kFreshTries = 64;
        parallelFor(lanes_.size(), [&](size_t i) {
            Lane& lane = lanes_[i];
            const auto evaluate = [&](SampleStream& u, Value& value) {
                const Evaluation<Value> one{&u, &value};
                model.evaluate({&one, 1});
            };
            lane.visibility.reevaluate(evaluate, lane.rng);
            lane.contribution.reevaluate(evaluate, lane.rng);
            State &v = lane.visibility.state(), &f = lane.contribution.state();
            if (v.value.visible() && f.value.visible()) return;
            State fresh;
            fresh.u = lane.lastVisible;
            for (int attempt = 0; attempt <= kFreshTries && !fresh.value.visible(); ++attempt) {
                if (attempt > 0) fresh.u.clear();
                PrimarySampleStream stream(fresh.u, lane.rng);
                evaluate(stream, fresh.value);
            }
            // While none is found the replica idles, which only loses samples.
            if (!fresh.value.visible()) return;
            ++lane.replaced;
            if (!v.value.visible()) v = fresh;
            if (!f.value.visible()) f = fresh;
        });
    }

    /// The step's uniform sample. `exchange`: the visibility replica moves in this step too. Returns whether
    /// it has received the sample.
    template <class Model>
    bool uniformStep(Model& model, size_t index, const ReplicaMixture& mix, bool exchange) {
        Lane& lane = lanes_[index];
        if (lane.passed == lane.taken) {
            lane.discardAhead();
            const size_t all = samplesOfLane(mix.uniform);
            takeUniform(model, index, std::min(all, lane.taken + kUniformBatch), mix);
        }
        const size_t sample = lane.passed++;
        if (lane.nextAhead == lane.ahead.size() || lane.ahead[lane.nextAhead].sample != sample)
            return false;  // it was invisible
        State& u = lane.ahead[lane.nextAhead++].state;
        u.weight = mix.uniformWeight(u.value.size);
        lane.squares.add(SplitEstimator::Uniform, square(u.value, mix));
        if (!exchange) {
            payOut(model, index, u);
            return false;
        }
        // Exchange with the visibility replica is certain for a visible sample [HJ11].
        payOut(model, index, lane.visibility.state());
        std::swap(u, lane.visibility.state());
        ++lane.uniformSwaps;
        return true;
    }

    /// A chain's mutation, which waits for its evaluation.
    template <class Chain>
    static Evaluation<Value> propose(Chain& chain, typename Lane::Proposal& proposal, CounterRng& rng) {
        return {&proposal.stream.emplace(chain.mutate(proposal.state, rng)), &proposal.state.value};
    }

    template <class Model>
    void visibilityStep(Model& model, size_t index, const ReplicaMixture& mix) {
        Lane& lane = lanes_[index];
        if (!lane.fresh) {
            State& proposal = lane.forVisibility.state;
            const double a = lane.visibility.acceptance(proposal);
            if (lane.visibility.decide(a, proposal, lane.rng)) payOut(model, index, proposal);
        }
        State& v = lane.visibility.state();
        v.weight += mix.visibilityWeight(v.value.size);
        lane.squares.add(SplitEstimator::Visibility, square(v.value, mix));
        if (v.value.visible()) lane.samples.addVisibility(v.value.size);
    }

    /// These samples enter the normalizations by Bennett's ratio only.
    template <class Model>
    void contributionStep(Model& model, size_t index, const ReplicaMixture& mix) {
        Lane& lane = lanes_[index];
        auto& chain = lane.contribution;
        State& proposal = lane.forContribution.state;
        const double a = chain.acceptance(proposal);
        proposal.weight = a * mix.contributionWeight(proposal.value.size);
        chain.state().weight += (1.0 - a) * mix.contributionWeight(chain.state().value.size);
        lane.squares.add(SplitEstimator::Contribution,
                         a * square(proposal.value, mix) + (1.0 - a) * square(chain.state().value, mix));
        chain.decide(a, proposal, lane.rng);
        payOut(model, index, proposal);  // the one of the two that the chain has left
        lane.samples.addContribution(chain.state().value.size);
        if (mix.visibility > 0 && lane.visibility.state().value.visible()) {
            ++lane.swapsTried;
            lane.swapsMade += exchangeReplicas(lane.visibility, lane.contribution, lane.rng);
        }
    }

    /// The replicas' samples of a lane are spread evenly over as many steps as the largest number of them.
    template <class Model>
    void runLanes(Model& model, size_t begin, size_t end, const ReplicaMixture& mix) {
        const double most = std::max({mix.uniform, mix.visibility, mix.contribution});
        const size_t steps = samplesOfLane(most);
        std::vector<Evaluation<Value>> proposals;
        for (size_t step = 0; step < steps; ++step) {
            const auto due = [&](double count) {
                const auto before = [&](size_t s) { return std::floor(double(s) * count / most); };
                return before(step + 1) > before(step);
            };
            const bool uniform = due(mix.uniform), visibility = due(mix.visibility),
                       contribution = due(mix.contribution);
            proposals.clear();
            for (size_t i = begin; i < end; ++i) {
                Lane& lane = lanes_[i];
                lane.fresh = uniform && uniformStep(model, i, mix, visibility);
                if (visibility && !lane.fresh)
                    proposals.push_back(propose(lane.visibility, lane.forVisibility, lane.rng));
                if (contribution)
                    proposals.push_back(propose(lane.contribution, lane.forContribution, lane.rng));
            }
            model.evaluate(std::span<const Evaluation<Value>>(proposals));
            for (size_t i = begin; i < end; ++i) {
                if (visibility) visibilityStep(model, i, mix);
                if (contribution) contributionStep(model, i, mix);
            }
        }
        for (size_t i = begin; i < end; ++i) {
            payOut(model, i, lanes_[i].visibility.state());
            payOut(model, i, lanes_[i].contribution.state());
        }
    }

    ReplicaSettings settings_;
    std::vector<Lane> lanes_;
    Normalization normalization_;
    SplitEstimator split_;
    bool sawChains_ = false;  ///< in this iteration
};

}  // namespace metrolux::core
