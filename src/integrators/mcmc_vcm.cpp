#include "integrators/mcmc_vcm.h"

#include "base/error.h"
#include "base/parallel.h"
#include "integrators/iteration.h"
#include "markov/chain.h"
#include "markov/normalisation.h"
#include "markov/replica_mixture.h"
#include "sampling/streams.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>

namespace metrolux {

namespace {

/// What a primary sample evaluates to.
struct Contribution {
    SplatList splats;
    double size = 0;  ///< F(u)
    bool visible() const { return size > 0; }
};
struct VisibilityTarget {
    double operator()(const Contribution& c) const { return c.visible() ? 1.0 : 0.0; }
};
struct ContributionTarget {
    double operator()(const Contribution& c) const { return c.size; }
};
using State = MarkovState<Contribution>;
using VisibilityChain = MarkovChain<Contribution, VisibilityTarget>;
using ContributionChain = MarkovChain<Contribution, ContributionTarget>;

/// Visible states that an iteration's chains are chosen from, at most. Their mean F enters the image as a
/// factor.
constexpr size_t kPoolSize = 16384;
/// With fewer visible uniform samples expected in an iteration, chains go on from the last one's states.
constexpr double kSmallestPool = 4;
/// Visible uniform samples that b_V is to rest on.
constexpr double kVisibleSamples = 256;

/// One independent set of the three replicas, with its own adaptation and random numbers. Lives across
/// iterations.
struct Lane {
    Lane(uint64_t seed, int index, MutationKernel::Kind kind)
        : rng(hashKey(seed, StreamPurpose::Chain, index)),
          visibility(VisibilityTarget{}, kind),
          contribution(ContributionTarget{}, kind) {}

    CounterRng rng;
    VisibilityChain visibility;
    ContributionChain contribution;
    /// A visible uniform sample that was taken before the chains of the iteration started.
    struct Early {
        size_t step;
        State state;
    };
    std::vector<Early> early;
    PrimarySample lastVisible;  ///< last visible uniform sample: replaces a state that became invisible
    State uniform, proposal;    ///< kept for their memory
    uint64_t swapsTried = 0, swapsMade = 0, uniformSwaps = 0, replaced = 0;
    Normalisation::Samples samples;
};

class McmcVcmIntegrator final : public Integrator {
  public:
    McmcVcmIntegrator(const Scene& scene, const IntegratorOptions& options)
        : scene_(scene),
          options_(options),
          partition_(scene.camera().window(), options),
          radius_(projectedPixelRadius(scene, options), options.radiusAlpha) {
        for (const char c : options.replicas)
            if (c != 'u' && c != 'v' && c != 'f')
                throw Error("replicas: found '{}', expected a combination of the letters u, v, f",
                            options.replicas);
        useUniform_ = options.replicas.find('u') != std::string::npos;
        useVisibility_ = options.replicas.find('v') != std::string::npos;
        useContribution_ = options.replicas.find('f') != std::string::npos;
        if (!useUniform_ && !useVisibility_ && !useContribution_)
            throw Error("replicas: found nothing, expected a combination of the letters u, v, f");
        const auto kind =
            options.adaptiveKernel ? MutationKernel::Kind::Adaptive : MutationKernel::Kind::Kelemen;
        if (options.correlationAware)
            photons_ = std::make_unique<PhotonDensity>(kPhotonCell * radius_.radius());
        for (int i = 0; i < laneCount(); ++i) lanes_.emplace_back(options.seed, i, kind);
    }

    void renderPass(Film& film) override {
        size_t first = 0;
        for (int part = 0; part < partition_.parts(); ++part) {
            iterate(film, partition_.pixels(part), first);
            first += partition_.pixels(part).size();
        }
        film.endPass();
        radius_.advance();
    }

    nlohmann::json statistics() const override;
    std::string progressNote() const override;

  private:
    /// A fixed number that depends on the image only: chains that take some thousand steps from their start
    /// in each iteration, and enough of them for many threads.
    int laneCount() const {
        constexpr int kStepsPerIteration = 1024, kFewest = 8, kMost = 64;
        if (options_.lanes > 0) return options_.lanes;
        const int samples = static_cast<int>(partition_.pixels(0).size());
        return std::clamp(samples / (3 * kStepsPerIteration), kFewest, kMost);
    }

    struct Acceptance {
        uint64_t tried = 0, accepted = 0;
        double theta = 0;  ///< mean over the lanes
        double rate() const { return tried ? double(accepted) / double(tried) : 0; }
    };
    static const MutationKernel& visibilityKernel(const Lane& lane) { return lane.visibility.kernel(); }
    static const MutationKernel& contributionKernel(const Lane& lane) { return lane.contribution.kernel(); }
    Acceptance acceptance(const MutationKernel& (*kernelOf)(const Lane&)) const;

    void iterate(Film& film, std::span<const uint32_t> pixels, size_t first);
    ReplicaMixture mixture(size_t samples) const;
    void collectSamples();
    void seedChains(uint32_t pass, size_t first, const std::vector<double>& sizes);
    void runLane(Lane& lane, const LightPass& pass, const ReplicaMixture& mix, size_t earlySteps,
                 size_t steps, Film& film, double filmShare);
    void uniformSample(Lane& lane, const LightPass& pass);
    size_t takeEarlySamples(const LightPass& pass, size_t steps);
    void startChains(const LightPass& pass, uint32_t passIndex, size_t first, double taken,
                     ReplicaMixture& mix);
    void renewStates(const LightPass& pass);
    static void evaluate(const LightPass& pass, SampleStream& stream, Contribution& c) {
        pass.evaluate(stream, c.splats);
        c.size = c.splats.size();
    }

    const Scene& scene_;
    IntegratorOptions options_;
    PixelPartition partition_;
    RadiusSchedule radius_;
    std::unique_ptr<PhotonDensity> photons_;  ///< null: not options.correlationAware
    bool useUniform_, useVisibility_, useContribution_;
    bool chainsSeeded_ = false, chainsReady_ = false;
    std::vector<Lane> lanes_;
    Normalisation normalisation_;
    EyeVertices eyes_;
    VertexGrid grid_;
};

/// Adds the splats of a state with the weight that it has earned.
void payOut(State& state, Film& film, double filmShare) {
    if (state.weight > 0) film.addSplats(state.value.splats, state.weight, state.weight * filmShare);
    state.weight = 0;
}

ReplicaMixture McmcVcmIntegrator::mixture(size_t samples) const {
    ReplicaMixture mix;
    if (!chainsSeeded_) {
        mix.uniform = double(samples);
        return mix;
    }
    mix.bVisibility = normalisation_.visibility();
    mix.bContribution = normalisation_.contribution();
    mix.inefficiency = options_.chainInefficiency;
    // Each lane takes steps of one sample of every replica in use; the counts are those really taken.
    const int kinds = useUniform_ + useVisibility_ + useContribution_;
    const size_t lanes = lanes_.size();
    const double perReplica = double(std::max<size_t>(1, (samples / kinds + lanes - 1) / lanes) * lanes);
    mix.uniform = useUniform_ ? perReplica : 0;
    mix.visibility = useVisibility_ ? perReplica : 0;
    mix.contribution = useContribution_ ? perReplica : 0;
    return mix;
}

void McmcVcmIntegrator::iterate(Film& film, std::span<const uint32_t> pixels, size_t first) {
    const double n = double(pixels.size()), r = radius_.radius();
    normalisation_.update(r * r);
    ReplicaMixture mix = mixture(pixels.size());
    const double lambda = mix.samples() * mix.boost() / n;
    const Strategies strategies =
        Strategies::bidirectional(lambda, n * std::numbers::pi * r * r, photons_.get());
    const double filmShare = n / film.pixelCount();

    EyePass{scene_, options_.limits, strategies, options_.seed, film.passes()}.run(pixels, film, eyes_);
    grid_.build(eyes_.all(), static_cast<float>(r));
    const LightPass pass{scene_, options_.limits, strategies, eyes_, grid_, film};

    if (!chainsReady_) {
        std::vector<double> sizes;
        plainLightPass(pass, film, options_.seed, film.passes(), first, pixels.size(), filmShare, &sizes,
                       photons_.get());
        if (photons_) photons_->endIteration(n);
        // Shared out among the lanes, so that the jackknife over lanes covers them.
        const size_t lanes = lanes_.size();
        for (size_t i = 0; i < sizes.size(); ++i) lanes_[i % lanes].samples.addUniform(sizes[i]);
        collectSamples();
        // b_V from a handful of samples is biased, and q and the weights with it: uniform passes go on until
        // it is known to a sixteenth. (Mitsuba's roughdielectric sphere, 48x48, b_V = 1e-4: 4 to 10 % too
        // dark after 64 passes before.)
        if (normalisation_.visibleSamples() < kVisibleSamples) return;
        // The first passes that see light make q known. The next are made of uniform samples too, with the
        // weights of q: those of q = 1 make another F, whose b_F can be wrong by a factor of two or more for
        // the chains.
        const bool calibrated = chainsSeeded_;
        seedChains(film.passes(), first, sizes);
        if (chainsSeeded_ && !calibrated) normalisation_.forgetSizes();
        chainsReady_ = calibrated;
        return;
    }
    const size_t steps =
        static_cast<size_t>(std::max({mix.uniform, mix.visibility, mix.contribution})) / lanes_.size();
    // Decided by what is expected, not by what is found: a choice by the samples themselves would bias them.
    const bool pooled = mix.uniform * mix.bVisibility >= kSmallestPool;
    for (Lane& lane : lanes_) lane.early.clear();
    const size_t earlySteps = pooled ? takeEarlySamples(pass, steps) : 0;
    if (pooled)
        startChains(pass, film.passes(), first, double(earlySteps * lanes_.size()), mix);
    else
        renewStates(pass);
    parallelFor(lanes_.size(),
                [&](size_t i) { runLane(lanes_[i], pass, mix, earlySteps, steps, film, filmShare); });
    if (photons_ && useUniform_) photons_->endIteration(mix.uniform);
    collectSamples();
}

void McmcVcmIntegrator::collectSamples() {
    for (size_t i = 0; i < lanes_.size(); ++i) {
        normalisation_.add(static_cast<int>(i), lanes_[i].samples);
        lanes_[i].samples.clear();
    }
    normalisation_.endIteration(radius_.radius() * radius_.radius());
}

void McmcVcmIntegrator::seedChains(uint32_t pass, size_t first, const std::vector<double>& sizes) {
    std::vector<double> visible(sizes.size());
    for (size_t i = 0; i < sizes.size(); ++i) visible[i] = sizes[i] > 0 ? 1.0 : 0.0;
    const DiscreteDistribution byVisibility(visible), bySize(sizes);
    if (byVisibility.empty()) return;

    CounterRng rng(hashKey(options_.seed, StreamPurpose::Seeding, pass));
    // A state is regenerated from the counter-based stream that made its value. Its coordinates are all those
    // that the evaluation may have asked for; more are appended when they are needed.
    const auto regenerate = [&](size_t index, PrimarySample& u) {
        IndependentStream stream(lightSubpathKey(options_.seed, pass, first + index));
        const int depth = options_.limits.maxDepth < 0 ? 32 : std::min(options_.limits.maxDepth, 32);
        u.resize(SampleStream::blockOffset(depth + 1));
        stream.seek(0);
        for (float& coordinate : u) coordinate = stream.next1D();
    };
    for (Lane& lane : lanes_) {
        float u = rng.next1D();
        const size_t visibleOne = byVisibility.sample(u);
        regenerate(visibleOne, lane.visibility.state().u);
        u = rng.next1D();
        const size_t chosen = bySize.sample(u);
        regenerate(chosen, lane.contribution.state().u);
        lane.lastVisible = lane.visibility.state().u;
    }
    chainsSeeded_ = true;
}

void McmcVcmIntegrator::uniformSample(Lane& lane, const LightPass& pass) {
    State& u = lane.uniform;
    u.u.clear();
    u.weight = 0;
    PrimarySampleStream stream(u.u, lane.rng);
    pass.evaluate(stream, u.value.splats, photons_.get());
    u.value.size = u.value.splats.size();
    lane.samples.addUniform(u.value.size);
    if (u.value.visible()) lane.lastVisible = u.u;
}

/// Takes the first of the iteration's uniform samples, until enough are visible to start the chains from.
/// Returns how many a lane has taken; the lanes keep the visible ones until their chains come to that step.
size_t McmcVcmIntegrator::takeEarlySamples(const LightPass& pass, size_t steps) {
    size_t taken = 0, visible = 0;
    const size_t round = std::max<size_t>(1, kPoolSize / lanes_.size());
    while (taken < steps && visible < kPoolSize) {
        const size_t end = std::min(steps, taken + round);
        parallelFor(lanes_.size(), [&](size_t i) {
            for (size_t step = taken; step < end; ++step) {
                uniformSample(lanes_[i], pass);
                if (!lanes_[i].uniform.value.visible()) continue;
                lanes_[i].early.push_back({step, std::exchange(lanes_[i].uniform, {})});
            }
        });
        taken = end;
        visible = 0;
        for (const Lane& lane : lanes_) visible += lane.early.size();
    }
    return taken;
}

/// The eye vertices and the radius are new, and with them the targets. Chains start from visible uniform
/// samples of this iteration: any of them for the visibility replica, chosen in proportion to F for the
/// contribution replica, with the scales that make such a start unbiased (ReplicaMixture). Going on from the
/// last iteration's states made short chains up to 9 % too bright (white sphere in glass, 32x32 pixels); the
/// same start without the scales made them 1.2 % too dark where F has heavy tails (veach-mis, 64x48).
void McmcVcmIntegrator::startChains(const LightPass& pass, uint32_t passIndex, size_t first, double taken,
                                    ReplicaMixture& mix) {
    std::vector<const State*> pool;
    std::vector<double> sizes;
    for (const Lane& lane : lanes_)
        for (const Lane::Early& e : lane.early) {
            pool.push_back(&e.state);
            sizes.push_back(e.state.value.size);
        }
    double sum = 0;
    for (const double size : sizes) sum += size;
    mix.visibilityScale = double(pool.size()) / (taken * mix.bVisibility);
    mix.contributionScale = sum / (taken * mix.bContribution);
    if (pool.empty()) {  // both scales are 0: what the chains find does not count
        renewStates(pass);
        return;
    }
    const DiscreteDistribution bySize(sizes);
    CounterRng rng(hashKey(options_.seed, StreamPurpose::Replacement, passIndex, first));
    const double lanes = double(lanes_.size()), offsetV = rng.nextDouble(), offsetF = rng.nextDouble();
    for (size_t i = 0; i < lanes_.size(); ++i) {
        const size_t v =
            std::min(pool.size() - 1, size_t((double(i) + offsetV) / lanes * double(pool.size())));
        float u = std::min(static_cast<float>((double(i) + offsetF) / lanes), kOneMinusEpsilon);
        lanes_[i].visibility.state() = *pool[v];
        lanes_[i].contribution.state() = *pool[bySize.sample(u)];
    }
}

void McmcVcmIntegrator::renewStates(const LightPass& pass) {
    // Light is too rare for startChains(): chains keep what they have found. Every state is evaluated again;
    // one that has become invisible is replaced by a visible uniform sample: the last one that the lane has
    // seen, or a fresh one. Resampling the lanes by new / old target was tried: it cannot reach what was
    // invisible before, so that short chains gathered where light is always visible and b_F ran away
    // (door-ajar, +30 %).
    constexpr int kFreshTries = 64;
    parallelFor(lanes_.size(), [&](size_t i) {
        Lane& lane = lanes_[i];
        const auto evaluateHere = [&](SampleStream& u, Contribution& c) { evaluate(pass, u, c); };
        lane.visibility.reevaluate(evaluateHere, lane.rng);
        lane.contribution.reevaluate(evaluateHere, lane.rng);
        State &v = lane.visibility.state(), &f = lane.contribution.state();
        if (v.value.visible() && f.value.visible()) return;
        State fresh;
        fresh.u = lane.lastVisible;
        for (int attempt = 0; attempt <= kFreshTries && !fresh.value.visible(); ++attempt) {
            if (attempt > 0) fresh.u.clear();
            PrimarySampleStream stream(fresh.u, lane.rng);
            evaluateHere(stream, fresh.value);
        }
        // While none is found the replica idles, which only loses samples.
        if (!fresh.value.visible()) return;
        ++lane.replaced;
        if (!v.value.visible()) v = fresh;
        if (!f.value.visible()) f = fresh;
    });
}

void McmcVcmIntegrator::runLane(Lane& lane, const LightPass& pass, const ReplicaMixture& mix,
                                size_t earlySteps, size_t steps, Film& film, double filmShare) {
    const auto evaluateHere = [&](SampleStream& stream, Contribution& c) { evaluate(pass, stream, c); };
    auto nextEarly = lane.early.begin();
    for (size_t step = 0; step < steps; ++step) {
        bool fresh = false;  // the visibility replica has received this step's uniform sample
        if (useUniform_) {
            State& u = lane.uniform;
            if (step >= earlySteps) {
                uniformSample(lane, pass);
            } else if (nextEarly != lane.early.end() && nextEarly->step == step) {
                std::swap(u, (nextEarly++)->state);
            } else {
                u.value.size = 0;
            }
            if (u.value.visible()) {
                u.weight = mix.uniformWeight(u.value.size);
                if (useVisibility_) {
                    // Exchange with the visibility replica is certain for a visible sample [HJ11].
                    payOut(lane.visibility.state(), film, filmShare);
                    std::swap(u, lane.visibility.state());
                    ++lane.uniformSwaps;
                    fresh = true;
                } else {
                    payOut(u, film, filmShare);
                }
            }
        }
        if (useVisibility_) {
            if (!fresh) {
                const double a = lane.visibility.propose(evaluateHere, lane.proposal, lane.rng);
                if (lane.visibility.decide(a, lane.proposal, lane.rng))
                    payOut(lane.proposal, film, filmShare);
            }
            State& v = lane.visibility.state();
            v.weight += mix.visibilityWeight(v.value.size);
            if (v.value.visible()) lane.samples.addVisibility(v.value.size);
        }
        if (useContribution_) {
            // These samples do not enter the normalisations: b_F estimated from them would feed what short
            // chains have not yet found back into their weight.
            ContributionChain& chain = lane.contribution;
            const double a = chain.propose(evaluateHere, lane.proposal, lane.rng);
            lane.proposal.weight = a * mix.contributionWeight(lane.proposal.value.size);
            chain.state().weight += (1.0 - a) * mix.contributionWeight(chain.state().value.size);
            chain.decide(a, lane.proposal, lane.rng);
            payOut(lane.proposal, film, filmShare);  // the one of the two that the chain has left
            if (useVisibility_ && lane.visibility.state().value.visible()) {
                ++lane.swapsTried;
                lane.swapsMade += exchangeReplicas(lane.visibility, lane.contribution, lane.rng);
            }
        }
    }
    payOut(lane.visibility.state(), film, filmShare);
    payOut(lane.contribution.state(), film, filmShare);
}

McmcVcmIntegrator::Acceptance McmcVcmIntegrator::acceptance(
    const MutationKernel& (*kernelOf)(const Lane&)) const {
    Acceptance sum;
    for (const Lane& lane : lanes_) {
        const MutationKernel& kernel = kernelOf(lane);
        sum.tried += kernel.tried();
        sum.accepted += kernel.accepted();
        sum.theta += kernel.theta() / double(lanes_.size());
    }
    return sum;
}

nlohmann::json McmcVcmIntegrator::statistics() const {
    uint64_t swapsTried = 0, swapsMade = 0, uniformSwaps = 0, replaced = 0;
    for (const Lane& lane : lanes_) {
        swapsTried += lane.swapsTried;
        swapsMade += lane.swapsMade;
        uniformSwaps += lane.uniformSwaps;
        replaced += lane.replaced;
    }
    const auto chain = [](const Acceptance& a) {
        return nlohmann::json{
            {"tried", a.tried}, {"accepted", a.accepted}, {"acceptance", a.rate()}, {"theta_mean", a.theta}};
    };
    const auto estimate = [](const Estimate& e) {
        nlohmann::json j{{"value", e.value}};
        if (std::isfinite(e.standardError)) j["standard_error"] = e.standardError;
        return j;
    };
    return {{"radius", radius_.radius()},
            {"parts", partition_.parts()},
            {"bytes_per_vertex", sizeof(Vertex)},
            {"stored_bytes", eyes_.memoryBytes() + grid_.memoryBytes()},
            {"lanes", lanes_.size()},
            {"replicas", options_.replicas},
            {"chain_inefficiency", options_.chainInefficiency},
            {"kernel", options_.adaptiveKernel ? "adaptive" : "kelemen"},
            {"b_v", estimate(normalisation_.visibilityEstimate())},
            {"b_f", estimate(normalisation_.contributionEstimate())},
            {"visibility_chain", chain(acceptance(visibilityKernel))},
            {"contribution_chain", chain(acceptance(contributionKernel))},
            {"exchange_visibility_contribution",
             {{"tried", swapsTried}, {"rate", swapsTried ? double(swapsMade) / double(swapsTried) : 0.0}}},
            {"exchange_uniform_visibility", uniformSwaps},
            {"states_replaced", replaced}};
}

std::string McmcVcmIntegrator::progressNote() const {
    if (!chainsSeeded_) return "no visible light subpath yet";
    return fmt::format("acceptance V {:.2f} F {:.2f}, b_V {:.2g}", acceptance(visibilityKernel).rate(),
                       acceptance(contributionKernel).rate(), normalisation_.visibility());
}

}  // namespace

std::unique_ptr<Integrator> makeMcmcVcmIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<McmcVcmIntegrator>(scene, options);
}

}  // namespace metrolux
