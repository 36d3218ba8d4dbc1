#pragma once
/// Integration by Metropolis sampling in primary sample space [Kel02], as PSSMLT and its relatives share it:
/// chains with large and small steps, expected values, an unbiased start.

#include "base/parallel.h"
#include "markov/chain.h"
#include "markov/replica_mixture.h"
#include "markov/replica_schedule.h"
#include "markov/start_pool.h"

namespace metrolux::core {

struct MetropolisOptions {
    uint64_t key = 0;  ///< of all random numbers
    int lanes = 8;     ///< independent chains; the result depends on it, not on the number of threads
    MutationKernel::Kind kind = MutationKernel::Kind::Kelemen;
    double largeStep = 0.3;         ///< probability of a uniform proposal
    size_t steeringSamples = 4096;  ///< for the normalization in the weights
    size_t poolSamples = 16384;     ///< for the start of the chains
    /// Adaptive kernel: mutations of each lane that theta is adapted to, before the chains count. kAlways: no
    /// training, theta adapts for ever.
    uint64_t trainingMutations = 512;
};

/// What a sampler's chains have done so far.
struct MetropolisCounts {
    uint64_t mutationsTried = 0, mutationsAccepted = 0, largeTried = 0, largeAccepted = 0, starts = 0;
    double theta = 0;  ///< of the adaptive kernel, mean over lanes
    MetropolisCounts& operator+=(const MetropolisCounts& other) {
        mutationsTried += other.mutationsTried;
        mutationsAccepted += other.mutationsAccepted;
        largeTried += other.largeTried;
        largeAccepted += other.largeAccepted;
        starts += other.starts;
        return *this;
    }
};

/// An observer of chains that looks away.
struct Unobserved {
    template <class State>
    void operator()(size_t, const State&, bool) const {}
};

/// Estimates integrals over primary sample space. `Value` is what a sample evaluates to; its member `size` is
/// the chains' target F, F = 0 where the integrand is zero. In all functions, `evaluate(SampleStream&,
/// Value&)` is the integrand and `pay(const Value&, double weight)` adds weight * value to the estimate; both
/// are called by many threads at once.
///
/// Weights. A run of n steps has p n uniform samples (large steps) and n samples of the chains, which the
/// balance heuristic combines, W = 1 / (p n + n F/b) [Kel02, section 3.2]; proposals and current states are
/// paid with their expected values.
///
/// Start. Chains start from uniform samples drawn in proportion to F, and their weights carry the mean of F
/// over those samples (StartPool) in place of the unknown normalization. Large steps enlarge the pool; once
/// it has doubled, the chains start again from it. So every run is unbiased, and the error of the
/// normalization falls with the number of all uniform samples. The b in W comes from samples of its own: it
/// steers weights only, and were it one with the pool's mean, W would be a function of the samples that it
/// weighs.
///
/// The adaptive kernel learns its steps on chains from the samples of b, whose states are then forgotten, and
/// keeps them: adapting while its states count made them up to 5 % too bright in the first 200 steps of a
/// toy (tests/unit/markov/metropolis_test.cpp).
template <class Value>
class MetropolisSampler {
  public:
    explicit MetropolisSampler(const MetropolisOptions& options)
        : options_(options), rng_(options.key), pool_(static_cast<size_t>(options.lanes)) {
        for (int i = 0; i < options.lanes; ++i) lanes_.emplace_back(hashKey(options.key, i), options);
    }

    /// Estimates the integral once, with `steps` samples: by steps of the chains, or by uniform samples as
    /// long as no sample is known where F > 0.
    template <class Evaluate, class Pay>
    void integrate(size_t steps, Evaluate&& evaluate, Pay&& pay) {
        if (!calibrate(evaluate)) {
            const double weight = 1.0 / double(steps);
            const auto visible = uniformSamples(steps, evaluate, [&](const Value& v) { pay(v, weight); });
            addSteering(visible, steps);
            train(visible, evaluate);
            return;
        }
        if (pool_.drawn() == 0)
            pool_.add(uniformSamples(options_.poolSamples, evaluate, [](const Value&) {}),
                      options_.poolSamples, rng_);
        if (pool_.drawn() >= 2 * drawnAtStart_) startChains(evaluate);
        run(steps, mixture(0, steps), evaluate, pay, Unobserved{});
    }

    /// As integrate(), for an integrand that is another in each call: the pool and the chains begin anew,
    /// with `fresh` uniform samples that are part of the estimate, and b is the mean over earlier calls.
    /// After each step of a chain, `observe(lane, state, moved)` sees its state (MarkovState<Value>) and
    /// whether it has changed.
    template <class Evaluate, class Pay, class Observe = Unobserved>
    void integrateAnew(size_t fresh, size_t steps, Evaluate&& evaluate, Pay&& pay, Observe&& observe = {}) {
        if (!calibrate(evaluate)) return integrate(fresh + steps, evaluate, pay);
        ReplicaMixture mix = mixture(fresh, steps);
        const auto visible =
            uniformSamples(fresh, evaluate, [&](const Value& v) { pay(v, mix.uniformWeight(v.size)); });
        pool_.clear();
        pool_.add(visible, fresh, rng_);
        startChains(evaluate);
        mix.contributionScale = scale_;
        run(steps, mix, evaluate, pay, observe);
        addSteering(visible, fresh);
    }

    /// Draws the samples that b rests on, if that has not been done; false while all of them are black.
    template <class Evaluate>
    bool calibrate(Evaluate&& evaluate) {
        if (steeringDrawn_ == 0) {
            const auto visible = uniformSamples(options_.steeringSamples, evaluate, [](const Value&) {});
            addSteering(visible, options_.steeringSamples);
            train(visible, evaluate);
        }
        return steeringSum_ > 0;
    }
    /// b as the weights have it.
    double steering() const { return steeringDrawn_ > 0 ? steeringSum_ / double(steeringDrawn_) : 0; }

    const StartPool& pool() const { return pool_; }
    using Counts = MetropolisCounts;
    Counts counts() const;

    size_t lanes() const { return lanes_.size(); }
    /// Current value of a lane's chain.
    const Value& value(size_t lane) const { return lanes_[lane].chain.state().value; }

    /// Between two calls. Chains go on from their values, which are part of it.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(rng_, pool_, steeringSum_, scale_, steeringDrawn_, drawnAtStart_, starts_);
        serializeElements(archive, lanes_, "lanes");
    }

  private:
    struct Target {
        double operator()(const Value& v) const { return v.size; }
    };
    struct Lane {
        Lane(uint64_t key, const MetropolisOptions& o)
            : rng(key), chain(Target{}, o.kind, o.trainingMutations) {}
        CounterRng rng;
        MarkovChain<Value, Target> chain;
        MarkovState<Value> proposal;  ///< kept for its memory
        std::vector<UniformSample> fresh;
        size_t freshDrawn = 0;
        uint64_t largeAccepted = 0, largeTried = 0;

        template <class Archive>
        void serialize(Archive& archive) {
            archive(rng, chain, chain.state().value, largeAccepted, largeTried);
        }
    };

    ReplicaMixture mixture(size_t fresh, size_t steps) const {
        ReplicaMixture mix;
        mix.uniform = double(fresh) + options_.largeStep * double(steps);
        mix.contribution = double(steps);
        mix.bContribution = steering();
        mix.contributionScale = scale_;
        return mix;
    }

    void addSteering(const std::vector<UniformSample>& visible, size_t drawn) {
        for (const UniformSample& s : visible) steeringSum_ += s.size;
        steeringDrawn_ += drawn;
    }

    /// Lets the kernels learn their steps, on chains that start from these samples.
    template <class Evaluate>
    void train(const std::vector<UniformSample>& visible, Evaluate&& evaluate) {
        if (visible.empty() || options_.trainingMutations == MutationKernel::kAlways) return;
        StartPool starts(lanes_.size());
        starts.add(visible, visible.size(), rng_);
        parallelFor(lanes_.size(), [&](size_t i) {
            Lane& lane = lanes_[i];
            if (lane.chain.kernel().settled()) return;
            uniformSample(evaluate, lane.chain.state(), starts.key(i));
            const double largeStep = std::min(options_.largeStep, 0.5);  // else it may take for ever
            while (!lane.chain.kernel().settled()) {
                const Proposed p = propose(lane, largeStep, evaluate);
                lane.chain.decide(p.acceptance, lane.proposal, lane.rng, !p.large);
            }
        });
    }

    struct Proposed {
        bool large;
        uint64_t key;  ///< of a large step
        double acceptance;
    };
    /// A small step or, with this probability, a large one, to lane.proposal.
    template <class Evaluate>
    Proposed propose(Lane& lane, double largeStep, Evaluate&& evaluate) {
        const bool large = lane.rng.nextDouble() < largeStep;
        const uint64_t key = lane.rng.nextBits();
        return {large, key,
                large ? lane.chain.proposeUniform(evaluate, lane.proposal, key)
                      : lane.chain.propose(evaluate, lane.proposal, lane.rng)};
    }

    /// Draws uniform samples; `use` sees those with F > 0, which are returned in a fixed order.
    template <class Evaluate, class Use>
    std::vector<UniformSample> uniformSamples(size_t count, Evaluate&& evaluate, Use&& use) {
        constexpr size_t kChunk = 256;
        const uint64_t key = rng_.nextBits();
        std::vector<std::vector<UniformSample>> visible((count + kChunk - 1) / kChunk);
        parallelFor(visible.size(), [&](size_t chunk) {
            MarkovState<Value> state;
            for (size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
                const uint64_t sampleKey = hashKey(key, i);
                uniformSample(evaluate, state, sampleKey);
                if (!(state.value.size > 0)) continue;
                visible[chunk].push_back({sampleKey, state.value.size});
                use(state.value);
            }
        });
        std::vector<UniformSample> result;
        for (const auto& part : visible) result.insert(result.end(), part.begin(), part.end());
        return result;
    }
    template <class Evaluate>
    void startChains(Evaluate&& evaluate) {
        ++starts_;
        drawnAtStart_ = pool_.drawn();
        scale_ = pool_.mean() / steering();
        if (pool_.empty()) return;  // scale 0: what the chains find does not count
        parallelFor(lanes_.size(),
                    [&](size_t i) { uniformSample(evaluate, lanes_[i].chain.state(), pool_.key(i)); });
    }

    template <class Evaluate, class Pay, class Observe>
    void run(size_t steps, const ReplicaMixture& mix, Evaluate&& evaluate, Pay&& pay, Observe&& observe) {
        const size_t n = lanes_.size();
        parallelFor(n, [&](size_t i) {
            const auto observeLane = [&](const auto& state, bool moved) { observe(i, state, moved); };
            runLane(lanes_[i], stepsOfLane(steps, n, i), mix, evaluate, pay, observeLane);
        });
        std::vector<UniformSample> fresh;
        size_t drawn = 0;
        for (Lane& lane : lanes_) {
            fresh.insert(fresh.end(), lane.fresh.begin(), lane.fresh.end());
            drawn += lane.freshDrawn;
            lane.fresh.clear();
            lane.freshDrawn = 0;
        }
        pool_.add(fresh, drawn, rng_);
    }

    template <class Evaluate, class Pay, class Observe>
    void runLane(Lane& lane, size_t steps, const ReplicaMixture& mix, Evaluate&& evaluate, Pay&& pay,
                 Observe&& observe) {
        auto& chain = lane.chain;
        for (size_t step = 0; step < steps; ++step) {
            MarkovState<Value>& proposal = lane.proposal;
            const auto [large, key, a] = propose(lane, options_.largeStep, evaluate);
            const double size = proposal.value.size;
            proposal.weight = a * mix.contributionWeight(size) + (large ? mix.uniformWeight(size) : 0);
            chain.state().weight += (1 - a) * mix.contributionWeight(chain.state().value.size);
            if (large) {
                ++lane.freshDrawn;
                if (size > 0) lane.fresh.push_back({key, size});
            }
            const bool accepted = chain.decide(a, proposal, lane.rng, !large);
            lane.largeTried += large;
            lane.largeAccepted += large && accepted;
            proposal.payOut(pay);  // the one of the two that the chain has left
            observe(chain.state(), accepted);
        }
        chain.state().payOut(pay);
    }

    MetropolisOptions options_;
    CounterRng rng_;
    StartPool pool_;
    std::vector<Lane> lanes_;
    double steeringSum_ = 0, scale_ = 0;  ///< scale_: mean of the pool over b, when the chains started
    size_t steeringDrawn_ = 0, drawnAtStart_ = 0;
    uint64_t starts_ = 0;
};

template <class Value>
auto MetropolisSampler<Value>::counts() const -> Counts {
    Counts sum;
    sum.starts = starts_;
    for (const Lane& lane : lanes_) {
        sum.mutationsTried += lane.chain.kernel().tried();
        sum.mutationsAccepted += lane.chain.kernel().accepted();
        sum.largeTried += lane.largeTried;
        sum.largeAccepted += lane.largeAccepted;
        sum.theta += lane.chain.kernel().theta() / double(lanes_.size());
    }
    return sum;
}

}  // namespace metrolux::core
