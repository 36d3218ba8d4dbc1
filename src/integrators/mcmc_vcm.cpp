#include "integrators/chain_choice.h"
#include "integrators/description.h"
#include "integrators/light_subpath_chains.h"
#include "integrators/resumable.h"

namespace metrolux::core {

namespace {

/// Kernel, replicas and all that steers them, and merging as in vcm.
struct McmcVcmParameters {
    /// Target F of the contribution replica.
    enum class Target {
        Luminance,  ///< what a light subpath adds to the image
        Relative    ///< the same over what the image shows there (PixelImportance)
    };
    MergingParameters merging;
    WeighingParameters weighing;
    VarianceParameters variance;
    double connections = 0;  ///< as ConnectionParameters; 0: kChainConnections or kIndependentConnections
    ReplicaParameters replicas{"uvf"};
    Target target = Target::Luminance;
    NormalizationMethod normalization = NormalizationMethod::Pooled;
    bool fixed = false;

    template <class V>
    void visit(V&& v) {
        v(merging);
        v(weighing);
        v(variance);
        v("connections", connections,
          Range::between(0, 1).zeroIs("1/64 of those from chains, 1/4 of independent ones"),
          "share of the light subpaths that are connected with an eye subpath; changes noise alone");
        v(replicas);
        v("target", target,
          Choices<Target>{{{"luminance", Target::Luminance}, {"relative", Target::Relative}}},
          "what chains of f look for; relative: to what the image shows there so far");
        v({"normalization", "normalisation"}, normalization,
          Choices<NormalizationMethod>{
              {{"pooled", NormalizationMethod::Pooled}, {"bennett", NormalizationMethod::Bennett}}},
          "of f: from samples of u and v, or from all by Bennett's ratio; changes noise alone");
        v("fixed", fixed, Flag{},
          "always chains, weighted by what is visible: nothing is chosen by the noise so far");
    }
};

/// Share of the light subpaths that are connected with an eye subpath. Connections cost as much as all else
/// that a light subpath does, and where chains find the light that is hard to find, merging carries most of
/// it: these shares have the smallest error in the same time on most of the scenes of docs/lab/results.md
/// ("Connections"). Where chains are no help, connections are.
constexpr double kChainConnections = 1.0 / 64, kIndependentConnections = 1.0 / 4;

ReplicaSettings settingsOf(uint64_t seed, const McmcVcmParameters& parameters, size_t samples) {
    ReplicaSettings settings = replicaSettings(seed, parameters.replicas, samples);
    settings.normalization = parameters.normalization;
    return settings;
}

/// Vertex connection and merging whose light subpaths come from Markov chains (Sik, Otsu, Hachisuka, Krivanek
/// 2016; docs/explain/algorithm.md, section 3). Eye subpaths are stratified Monte Carlo.
class McmcVcmIntegrator final : public Resumable<McmcVcmIntegrator, IteratedIntegrator> {
  public:
    McmcVcmIntegrator(const Scene& scene, const CommonOptions& options, const McmcVcmParameters& parameters)
        : Resumable(scene, options, parameters.merging),
          parameters_(parameters),
          chains_(settingsOf(options.seed, parameters, partition_.pixels(0).size())),
          choosing_(!parameters.fixed && parameters.replicas.replicas == parameters.replicas.possible) {
        chains_.measureDensity = !parameters.fixed;
        weighByPhotons(parameters.weighing);
        weighByVariance(parameters.variance);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
        archive(chains_, choice_);
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = chains_.statistics();
        j.update(iterationStatistics());
        j["light_subpaths"] = usesChains() ? "chains" : "independent";
        j["boost"] = chains_.density().ofShared() / samples();
        j["gain_of_chains"] = gainOfChains();
        return j;
    }
    std::string progressNote() const override {
        return chains_.progressNote() + (usesChains() ? "" : ", independent light subpaths");
    }

  private:
    void iterate(Film& film, uint32_t pass, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size()), r = radius_.radius();
        chains_.begin(pixels.size(), r, usesChains());
        Strategies strategies = Strategies::bidirectional(chains_.effectiveSamples() / n,
                                                          n * std::numbers::pi * r * r, photons_.get());
        strategies.eyeFactors = eyeFactors_.get();
        strategies.connect = parameters_.connections;
        if (!(strategies.connect > 0))
            strategies.connect = usesChains() ? kChainConnections : kIndependentConnections;
        traceEyes(eyePass(strategies, pass), pixels, film);
        grid_.build(positionsOf(eyes_.all()), static_cast<float>(r));
        const LightSubpathPass light = lightSubpathPass(strategies);
        const bool relative = parameters_.target == McmcVcmParameters::Target::Relative;
        const bool measured = parameters_.replicas.split.measured || (choosing_ && choice_.judging());
        if (first == 0 && (relative || measured)) importance_.update(film);
        LightSubpathIteration iteration{pass, first, pixels.size(), n / film.pixelCount()};
        if (relative) iteration.target = &importance_;
        if (measured) iteration.noise = &importance_;
        chains_.run(light, film, iteration, photons_.get());
    }

    /// Light subpaths of an iteration.
    double samples() const { return double(partition_.pixels(0).size()); }
    double gainOfChains() const { return chains_.density().ofNoise() / samples(); }
    bool usesChains() const { return !choosing_ || choice_.chains(); }
    void endPass() override {
        if (choosing_ && chains_.ready()) choice_.endPass(gainOfChains());
    }

    McmcVcmParameters parameters_;
    LightSubpathChains chains_;
    bool choosing_;
    ChainChoice choice_;
    PixelImportance importance_;
};

}  // namespace

IntegratorDescription mcmcVcmIntegrator() {
    return describe<McmcVcmParameters, McmcVcmIntegrator>(
        "mcmc_vcm", "VCM whose light subpaths come from Markov chains (default; robust on hard light)",
        {"mlt"});
}

}  // namespace metrolux::core
