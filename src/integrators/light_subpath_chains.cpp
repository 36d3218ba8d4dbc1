#include "integrators/light_subpath_chains.h"

#include "base/error.h"
#include "wavefront/light_subpath_wavefront.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace metrolux::core {

namespace {

/// A pass over light subpaths as the model of ReplicaLanes.
struct LightSubpathModel {
    const LightSubpathPass& pass;
    Film& film;
    const LightSubpathIteration& iteration;
    PhotonDensity* photons;
    std::vector<std::vector<Vec3f>>* trails;  ///< of each lane, may be null
    const ReplicaMixture& mix;
    MixtureDensity* density;                      ///< measured, if given
    std::vector<LightSubpathChains::Sums>& sums;  ///< of each lane
    double squaresOfFilm = 1;                     ///< as PixelImportance::squares()

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
            c->squares =
                iteration.noise ? iteration.noise->squares(c->splats, squaresOfFilm) : c->size * c->size;
        }
    }
    void pay(size_t lane, const LightSubpathContribution& c, double weight) const {
        film.addSplats(c.splats, weight, weight * iteration.filmShare);
        if (density) density->add(lane, weight, mix.uniformWeight(c.size), c.splats.shared);
        sums[lane].surprise += weight * c.splats.surprise;
        sums[lane].squares += weight * c.squares;
        if (trails) (*trails)[lane].insert((*trails)[lane].end(), c.trail.begin(), c.trail.end());
    }
};

}  // namespace

ReplicaSettings replicaSettings(uint64_t seed, const ReplicaParameters& parameters, size_t samples) {
    const auto has = [&](char letter) { return parameters.replicas.find(letter) != std::string::npos; };
    ReplicaSettings s;
    s.seed = seed;
    s.kernel = parameters.chains.kernel;
    s.inefficiency = parameters.inefficiency.chainInefficiency;
    s.lanes = laneCount(parameters.chains, samples / 3);  // of each replica
    s.uniform = has('u');
    s.visibility = has('v');
    s.contribution = has('f');
    s.split = parameters.split.parts;
    s.measuredSplit = parameters.split.measured;
    if (s.measuredSplit && !s.contribution)
        throw Error("split: `auto` weighs the replicas of mcmc_vcm against each other, replica f among them");
    s.pooledTheta = parameters.pooledTheta;
    return s;
}

void LightSubpathChains::begin(size_t samples, double radius, bool chains) {
    squaredRadius_ = radius * radius;
    lanes_.normalization().update(squaredRadius_);
    chainsRun_ = chains && ready_;
    if (boostKnown_ && (chains || !ready_)) {
        mix_ = lanes_.mixture(samples);
    } else {
        mix_ = {};
        mix_.uniform = double(samples);
    }
}

double LightSubpathChains::effectiveSamples() const {
    if (chainsRun_ && density_.ofShared() > 0) return density_.ofShared();
    return mix_.samples() * mix_.boost();
}

void LightSubpathChains::run(const LightSubpathPass& pass, Film& film, const LightSubpathIteration& iteration,
                             PhotonDensity* photons) {
    for (std::vector<Vec3f>& t : trails_) t.clear();
    if (!ready_) return plainRun(pass, film, iteration, photons);
    // Their sizes are those of other weights than the chains', and do not enter b_V and b_F.
    if (!chainsRun_) return independentRun(pass, film, iteration, photons, nullptr);
    const LightSubpathModel model{pass,
                                  film,
                                  iteration,
                                  photons,
                                  keepTrails ? &trails_ : nullptr,
                                  mix_,
                                  measureDensity ? &density_ : nullptr,
                                  sums_,
                                  sqr(iteration.filmShare) * film.filter().squaredWeights()};
    std::fill(sums_.begin(), sums_.end(), Sums{});
    lanes_.run(model, mix_, iteration.pass, iteration.first);
    if (photons && mix_.uniform > 0) photons->endIteration(mix_.uniform);
    lanes_.endIteration(squaredRadius_);
    density_.endIteration();
}

void LightSubpathChains::independentRun(const LightSubpathPass& pass, Film& film,
                                        const LightSubpathIteration& iteration, PhotonDensity* photons,
                                        std::vector<double>* sizes) {
    independentLightSubpaths(pass, film, lanes_.settings().seed, iteration, photons, sizes);
    if (photons) photons->endIteration(double(iteration.count));
}

void LightSubpathChains::plainRun(const LightSubpathPass& pass, Film& film,
                                  const LightSubpathIteration& iteration, PhotonDensity* photons) {
    std::vector<double> sizes;
    independentRun(pass, film, iteration, photons, &sizes);
    lanes_.addUniform(sizes);
    lanes_.endIteration(squaredRadius_);
    // b_V from a handful of samples is biased, and q and the weights with it: uniform passes go on until it
    // is known to a sixteenth. (Mitsuba's roughdielectric sphere, 48x48, b_V = 1e-4: 4 to 10 % too dark after
    // 64 passes before.)
    if (lanes_.normalization().visibleSamples() < kVisibleSamples) return;
    // The first passes that see light make q known. The next are made of uniform samples too, with the
    // weights of q: those of q = 1 make another F, whose b_F can be wrong by a factor of two or more for the
    // chains.
    if (!boostKnown_) lanes_.normalization().forgetSizes();
    ready_ = std::exchange(boostKnown_, true);
}

Surprise LightSubpathChains::surprise() const {
    Surprise sum;
    for (const Sums& s : sums_) sum += s.surprise;
    return sum;
}

double LightSubpathChains::squares() const {
    double sum = 0;
    for (const Sums& s : sums_) sum += s.squares;
    return sum;
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
                     {"b_v", estimate(normalization.visibilityEstimate())},
                     {"visibility_chain", chain(counts.visibility)},
                     {"exchange_uniform_visibility", counts.uniformSwaps}};
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
    if (!boostKnown_) return "no visible light subpath yet";
    const ReplicaCounts counts = lanes_.counts();
    std::string note = fmt::format("acceptance V {:.2f}", counts.visibility.rate());
    if (lanes_.settings().contribution) note += fmt::format(" F {:.2f}", counts.contribution.rate());
    return note + fmt::format(", b_V {:.2g}", lanes_.normalization().visibility());
}

}  // namespace metrolux::core
