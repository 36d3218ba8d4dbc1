#include "integrators/light_subpath_chains.h"

#include "base/error.h"
#include "wavefront/light_subpath_wavefront.h"

#include <fmt/format.h>

namespace metrolux::core {

namespace {

/// A pass over light subpaths as the model of ReplicaLanes.
struct LightSubpathModel {
    const LightSubpathPass& pass;
    Film& film;
    const LightSubpathIteration& iteration;
    PhotonDensity* photons;
    std::vector<std::vector<Vec3f>>* trails;  ///< of each lane, may be null

    void startUniform(PrimarySample&, CounterRng&, size_t, size_t) const {}
    using Evaluations = std::span<const Evaluation<LightSubpathContribution>>;
    void evaluateUniform(Evaluations evaluations) const { evaluate(evaluations, photons, Coherence::None); }
    void evaluate(Evaluations evaluations) const { evaluate(evaluations, nullptr, Coherence::Alone); }
    void evaluate(Evaluations evaluations, PhotonDensity* counted, Coherence coherence) const {
        std::vector<LightSubpathJob> jobs;
        for (const auto& [stream, c] : evaluations)
            jobs.push_back({stream, &c->splats, counted, trails ? &c->trail : nullptr});
        evaluateTogether(pass, jobs, coherence);
        for (const auto& [stream, c] : evaluations) {
            c->size = sizeOf(c->splats, iteration.target);
            c->squares = iteration.noise ? iteration.noise->squares(c->splats) : c->size * c->size;
        }
    }
    void pay(size_t lane, const LightSubpathContribution& c, double weight) const {
        film.addSplats(c.splats, weight, weight * iteration.filmShare);
        if (trails) (*trails)[lane].insert((*trails)[lane].end(), c.trail.begin(), c.trail.end());
    }
};

std::string lettersOf(const ReplicaSettings& s) {
    return std::string(s.uniform ? "u" : "") + (s.visibility ? "v" : "") + (s.contribution ? "f" : "");
}

}  // namespace

ReplicaSettings replicaSettings(const IntegratorOptions& options, const std::string& letters,
                                MutationKernel::Kind kernel, size_t samples) {
    const std::string chosen = options.replicas.value_or(letters);
    if (chosen.empty() || chosen.find_first_not_of(letters) != std::string::npos)
        throw Error("replicas: found '{}', expected a combination of the letters {}", chosen,
                    fmt::join(letters, ", "));
    const auto has = [&](char letter) { return chosen.find(letter) != std::string::npos; };
    ReplicaSettings s;
    s.seed = options.seed;
    s.kernel = options.kernel.value_or(kernel);
    s.inefficiency = options.chainInefficiency;
    s.lanes = laneCount(options, samples / 3);  // of each replica
    s.uniform = has('u');
    s.visibility = has('v');
    s.contribution = has('f');
    s.split = options.split;
    s.measuredSplit = options.measuredSplit;
    if (s.measuredSplit && !s.contribution)
        throw Error("split: `auto` weighs the replicas of mcmc_vcm against each other, replica f among them");
    s.normalization = options.normalization;
    s.pooledTheta = options.pooledTheta;
    return s;
}

void LightSubpathChains::begin(size_t samples, double radius) {
    squaredRadius_ = radius * radius;
    lanes_.normalization().update(squaredRadius_);
    if (seeded_) {
        mix_ = lanes_.mixture(samples);
    } else {
        mix_ = {};
        mix_.uniform = double(samples);
    }
}

void LightSubpathChains::run(const LightSubpathPass& pass, Film& film, const LightSubpathIteration& iteration,
                             PhotonDensity* photons) {
    for (std::vector<Vec3f>& t : trails_) t.clear();
    if (!ready_) {
        plainRun(pass, film, iteration, photons);
        return;
    }
    const LightSubpathModel model{pass, film, iteration, photons, keepTrails ? &trails_ : nullptr};
    lanes_.run(model, mix_, iteration.pass, iteration.first);
    if (photons && mix_.uniform > 0) photons->endIteration(mix_.uniform);
    lanes_.endIteration(squaredRadius_);
}

void LightSubpathChains::plainRun(const LightSubpathPass& pass, Film& film,
                                  const LightSubpathIteration& iteration, PhotonDensity* photons) {
    std::vector<double> sizes;
    independentLightSubpaths(pass, film, lanes_.settings().seed, iteration, photons, &sizes);
    if (photons) photons->endIteration(double(iteration.count));
    lanes_.addUniform(sizes);
    lanes_.endIteration(squaredRadius_);
    // b_V from a handful of samples is biased, and q and the weights with it: uniform passes go on until it
    // is known to a sixteenth. (Mitsuba's roughdielectric sphere, 48x48, b_V = 1e-4: 4 to 10 % too dark after
    // 64 passes before.)
    if (lanes_.normalization().visibleSamples() < kVisibleSamples) return;
    // The first passes that see light make q known. The next are made of uniform samples too, with the
    // weights of q: those of q = 1 make another F, whose b_F can be wrong by a factor of two or more for the
    // chains.
    const bool calibrated = seeded_;
    seedChains(iteration, sizes);
    if (seeded_ && !calibrated) lanes_.normalization().forgetSizes();
    ready_ = calibrated;
}

void LightSubpathChains::seedChains(const LightSubpathIteration& iteration,
                                    const std::vector<double>& sizes) {
    std::vector<double> visible(sizes.size());
    for (size_t i = 0; i < sizes.size(); ++i) visible[i] = sizes[i] > 0 ? 1.0 : 0.0;
    const DiscreteDistribution byVisibility(visible), bySize(sizes);
    if (byVisibility.empty()) return;

    const uint64_t seed = lanes_.settings().seed;
    CounterRng rng(hashKey(seed, StreamPurpose::Seeding, iteration.pass));
    // A state is regenerated from the counter-based stream that made its value. Its coordinates are all those
    // that the evaluation may have asked for; more are appended when they are needed.
    const auto regenerate = [&](const DiscreteDistribution& choice, PrimarySample& u) {
        float uChoice = rng.next1D();
        IndependentStream stream(
            lightSubpathKey(seed, iteration.pass, iteration.first + choice.sample(uChoice)));
        const int depth = limits_.maxDepth < 0 ? 32 : std::min(limits_.maxDepth, 32);
        u.resize(SampleStream::blockOffset(depth + 1));
        layout::readAll(stream, u);
    };
    lanes_.seed([&](PrimarySample& visibility, PrimarySample& contribution) {
        regenerate(byVisibility, visibility);
        regenerate(bySize, contribution);
    });
    seeded_ = true;
}

std::vector<Vec3f> LightSubpathChains::trails() const {
    std::vector<Vec3f> all;
    for (const std::vector<Vec3f>& t : trails_) all.insert(all.end(), t.begin(), t.end());
    return all;
}

nlohmann::json replicaStatistics(const ReplicaSettings& settings, const ReplicaCounts& counts,
                                 const Normalization& normalization) {
    const auto estimate = [](const Estimate& e) {
        nlohmann::json j{{"value", e.value}};
        if (std::isfinite(e.standardError)) j["standard_error"] = e.standardError;
        return j;
    };
    const auto chain = [](const ReplicaCounts::Acceptance& a) {
        return nlohmann::json{
            {"tried", a.tried}, {"accepted", a.accepted}, {"acceptance", a.rate()}, {"theta_mean", a.theta}};
    };
    nlohmann::json j{{"lanes", settings.lanes},
                     {"replicas", lettersOf(settings)},
                     {"chain_inefficiency", settings.inefficiency},
                     {"kernel", settings.kernel == MutationKernel::Kind::Adaptive ? "adaptive" : "kelemen"},
                     {"b_v", estimate(normalization.visibilityEstimate())},
                     {"visibility_chain", chain(counts.visibility)},
                     {"exchange_uniform_visibility", counts.uniformSwaps},
                     {"states_replaced", counts.replaced}};
    if (settings.contribution) {
        j["b_f"] = estimate(normalization.contributionEstimate());
        j["contribution_chain"] = chain(counts.contribution);
        const double tried = double(counts.swapsTried);
        j["exchange_visibility_contribution"] = {{"tried", counts.swapsTried},
                                                 {"rate", tried > 0 ? double(counts.swapsMade) / tried : 0}};
    }
    return j;
}

nlohmann::json LightSubpathChains::statistics() const {
    nlohmann::json j = replicaStatistics(lanes_.settings(), lanes_.counts(), lanes_.normalization());
    j["split"] = lanes_.split();
    return j;
}

std::string LightSubpathChains::progressNote() const {
    if (!seeded_) return "no visible light subpath yet";
    const ReplicaCounts counts = lanes_.counts();
    std::string note = fmt::format("acceptance V {:.2f}", counts.visibility.rate());
    if (lanes_.settings().contribution) note += fmt::format(" F {:.2f}", counts.contribution.rate());
    return note + fmt::format(", b_V {:.2g}", lanes_.normalization().visibility());
}

}  // namespace metrolux::core
