#include "integrators/description.h"
#include "integrators/light_subpath_set.h"
#include "integrators/path_chains.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

#include <optional>

namespace metrolux::core {

namespace {

/// Which light subpaths are merged with (supplement, 4.1.1).
enum class LightSet {
    Visibility,  ///< method B
    States       ///< method A
};

struct PssmltMergeParameters {
    MetropolisParameters chains;
    MergingParameters merging;
    WeighingParameters weighing;
    InefficiencyParameters inefficiency;
    LightSet method = LightSet::Visibility;
    template <class V>
    void visit(V&& v) {
        v(chains);
        v(merging);
        v(weighing);
        v(inefficiency);
        v("method", method, Choices<LightSet>{{{"B", LightSet::Visibility}, {"A", LightSet::States}}},
          "light subpaths to merge with: B from a visibility chain, A (biased) from the chains' states");
    }
};

/// Part of an iteration's samples that are uniform and start the chains: L is another in each, and the target
/// with it.
constexpr double kFreshShare = 0.25;

CommonOptions forTwoSets(CommonOptions options) {
    options.memoryBytes /= 2;  // the vertices of eye and of light subpaths are stored
    return options;
}

/// pssmlt whose eye subpaths are merged with a set L of light subpaths besides (supplement of Sik et al.
/// 2016, section 4.1), weighted as in vertex connection and merging. Method B: L from a visibility-driven
/// chain [HJ11]. Method A, experimental: L from the states of pssmlt's own chains, whose density is estimated
/// (biased).
class PssmltMergeIntegrator final : public Resumable<PssmltMergeIntegrator, IteratedIntegrator> {
  public:
    PssmltMergeIntegrator(const Scene& scene, const CommonOptions& options,
                          const PssmltMergeParameters& parameters)
        : Resumable(scene, forTwoSets(options), parameters.merging),
          sampler_(pathSamplerOptions(options.seed, parameters.chains, partition_.pixels(0).size(), 0)),
          byVisibility_(options.seed, parameters.chains.chains, parameters.inefficiency.chainInefficiency,
                        partition_.pixels(0).size()) {
        if (parameters.method == LightSet::States)
            byStates_.emplace(options.seed, kPhotonCell * radius_.radius(), sampler_.lanes());
        weighByPhotons(parameters.weighing);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
        archive(sampler_, byVisibility_);
        checkPixels(sampler_, scene_.camera().window());
        if (byStates_) archive(*byStates_);
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = samplerStatistics(sampler_);
        j.update(iterationStatistics());
        j["stored_bytes"] = j["stored_bytes"].get<size_t>() + map_.memoryBytes();
        if (!byStates_) j["light_subpaths"] = byVisibility_.statistics();
        return j;
    }
    std::string progressNote() const override { return acceptanceNote(sampler_.counts()); }

  private:
    void iterate(Film& film, uint32_t pass, std::span<const uint32_t> pixels, size_t first) override {
        const size_t n = pixels.size(), fresh = static_cast<size_t>(kFreshShare * double(n));
        const double r = radius_.radius();
        if (!byStates_) byVisibility_.begin(n, r);
        const double lightSubpaths =
            byStates_ ? byStates_->effectiveSamples(n) : byVisibility_.effectiveSamples();
        Strategies strategies =
            Strategies::bidirectional(1, lightSubpaths * std::numbers::pi * r * r, photons_.get());
        strategies.wavelength = wavelength(pass);  // of the map, and so of all paths
        tracePixels(film, pass, pixels, strategies);
        const LightSubpathTracing tracing{scene_, options_.limits, strategies, photons_.get()};
        map_.build(byStates_ ? byStates_->make(tracing, n, pass, first) : byVisibility_.make(tracing, grid_),
                   static_cast<float>(r));

        const PathPair pair{scene_, options_.limits, strategies, film, nonFinite_, &map_};
        const auto observe = [this](size_t lane, const auto& state, bool moved) {
            if (byStates_) byStates_->observe(lane, state, moved);
        };
        sampler_.integrateAnew(fresh, n - fresh, evaluatorOf(pair),
                               payTo(film, double(n) / film.pixelCount()), observe);
    }

    /// Emitters that the camera sees directly, and for method B the eye vertices that say what is visible.
    void tracePixels(Film& film, uint32_t pass, std::span<const uint32_t> pixels,
                     const Strategies& strategies) {
        directPass(eyePass(strategies, pass), pixels, film);
        if (byStates_) return;
        Strategies merges = strategies;
        merges.hit = merges.nee = 0;
        traceEyes(eyePass(merges, pass), pixels, film);
        grid_.build(positionsOf(eyes_.all()), static_cast<float>(radius_.radius()));
    }

    PathSampler sampler_;
    VisibilityDrivenSet byVisibility_;       ///< method B
    std::optional<ChainStateSet> byStates_;  ///< method A
    PhotonMap map_;
};

}  // namespace

IntegratorDescription pssmltMergeIntegrator() {
    return describe<PssmltMergeParameters, PssmltMergeIntegrator>(
        "pssmlt_merge",
        "chains of pssmlt that also merge with light subpaths from chains (method A or B of the paper)");
}

}  // namespace metrolux::core
