#include "integrators/pssmlt_merge.h"

#include "base/error.h"
#include "integrators/light_subpath_set.h"
#include "integrators/path_chains.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

#include <optional>

namespace metrolux::core {

namespace {

/// Part of an iteration's samples that are uniform and start the chains: L is another in each, and the target
/// with it.
constexpr double kFreshShare = 0.25;

IntegratorOptions forTwoSets(IntegratorOptions options) {
    options.memoryBytes /= 2;  // the vertices of eye and of light subpaths are stored
    return options;
}

class PssmltMergeIntegrator final : public Resumable<PssmltMergeIntegrator, IteratedIntegrator> {
  public:
    PssmltMergeIntegrator(const Scene& scene, const IntegratorOptions& options)
        : Resumable(scene, forTwoSets(options), projectedPixelRadius(scene, options)),
          sampler_(pathSamplerOptions(options, partition_.pixels(0).size(), 0)),
          byVisibility_(options, partition_.pixels(0).size()) {
        if (options.mergeMethod != 'A' && options.mergeMethod != 'B')
            throw Error("method: found '{}', expected A or B", options.mergeMethod);
        if (options.mergeMethod == 'A')
            byStates_.emplace(options, kPhotonCell * radius_.radius(), sampler_.lanes());
        weighByPhotons();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
        archive(sampler_, byVisibility_);
        checkPixels(sampler_, scene_.camera().window());
        if (byStates_) archive(*byStates_);
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = chainStatistics(options_);
        j.update(samplerStatistics(sampler_));
        j["method"] = std::string(1, options_.mergeMethod);
        j.update(iterationStatistics());
        j["stored_bytes"] = j["stored_bytes"].get<size_t>() + map_.memoryBytes();
        if (!byStates_) j["light_subpaths"] = byVisibility_.statistics();
        return j;
    }
    std::string progressNote() const override { return acceptanceNote(sampler_.counts()); }

  private:
    void iterate(Film& film, std::span<const uint32_t> pixels, size_t first) override {
        const size_t n = pixels.size(), fresh = static_cast<size_t>(kFreshShare * double(n));
        const double r = radius_.radius();
        if (!byStates_) byVisibility_.begin(n, r);
        const double lightSubpaths =
            byStates_ ? byStates_->effectiveSamples(n) : byVisibility_.effectiveSamples();
        const Strategies strategies =
            Strategies::bidirectional(1, lightSubpaths * std::numbers::pi * r * r, photons_.get());
        tracePixels(film, pixels, strategies);
        const LightSubpathTracing tracing{scene_, options_.limits, strategies, photons_.get()};
        map_.build(byStates_ ? byStates_->make(tracing, n, film.passIndex(), first)
                             : byVisibility_.make(tracing, grid_),
                   static_cast<float>(r));

        const PathPair pair{scene_, options_.limits, strategies, film, &map_};
        const auto observe = [this](size_t lane, const auto& state, bool moved) {
            if (byStates_) byStates_->observe(lane, state, moved);
        };
        sampler_.integrateAnew(fresh, n - fresh, evaluatorOf(pair),
                               payTo(film, double(n) / film.pixelCount()), observe);
    }

    /// Emitters that the camera sees directly, and for method B the eye vertices that say what is visible.
    void tracePixels(Film& film, std::span<const uint32_t> pixels, const Strategies& strategies) {
        directPass(scene_, options_.limits, options_.seed, pixels, film);
        if (byStates_) return;
        Strategies merges = strategies;
        merges.hit = merges.nee = 0;
        traceEyes(merges, pixels, film);
        grid_.build(eyes_.all(), static_cast<float>(radius_.radius()));
    }

    PathSampler sampler_;
    VisibilityDrivenSet byVisibility_;        ///< method B
    std::optional<ChainStateSet> byStates_;  ///< method A
    PhotonMap map_;
};

}  // namespace

std::unique_ptr<Integrator> makePssmltMergeIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<PssmltMergeIntegrator>(scene, options);
}

}  // namespace metrolux::core
