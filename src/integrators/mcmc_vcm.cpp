#include "integrators/mcmc_vcm.h"

#include "integrators/light_subpath_chains.h"
#include "integrators/resumable.h"

namespace metrolux::core {

namespace {

/// Share of the light subpaths that are connected. Connections cost as much as all else that a light subpath
/// does, and where chains find the light that is hard to find, merging carries most of it: this share has the
/// smallest error in the same time on most of the scenes of docs/lab/results.md ("Connections").
constexpr double kConnections = 1.0 / 16;

class McmcVcmIntegrator final : public Resumable<McmcVcmIntegrator, IteratedIntegrator> {
  public:
    McmcVcmIntegrator(const Scene& scene, const IntegratorOptions& options)
        : Resumable(scene, options, projectedPixelRadius(scene, options)),
          chains_(replicaSettings(options, "uvf", MutationKernel::Kind::Kelemen, partition_.pixels(0).size()),
                  options.limits) {
        weighByPhotons();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
        archive(chains_);
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = chains_.statistics();
        j.update(iterationStatistics());
        return j;
    }
    std::string progressNote() const override { return chains_.progressNote(); }

  private:
    void iterate(Film& film, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size()), r = radius_.radius();
        chains_.begin(pixels.size(), r);
        Strategies strategies = Strategies::bidirectional(chains_.effectiveSamples() / n,
                                                          n * std::numbers::pi * r * r, photons_.get());
        strategies.connect = options_.connections.value_or(kConnections);
        traceEyes(strategies, pixels, film);
        grid_.build(eyes_.all(), static_cast<float>(r));
        const LightSubpathPass light{scene_, options_.limits, strategies, eyes_, grid_, film};
        const bool relative = options_.target == ChainTarget::Relative;
        if (first == 0 && (relative || options_.measuredSplit)) importance_.update(film);
        LightSubpathIteration iteration{film.passIndex(), first, pixels.size(), n / film.pixelCount()};
        if (relative) iteration.target = &importance_;
        if (options_.measuredSplit) iteration.noise = &importance_;
        chains_.run(light, film, iteration, photons_.get());
    }

    LightSubpathChains chains_;
    PixelImportance importance_;
};

}  // namespace

std::unique_ptr<Integrator> makeMcmcVcmIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<McmcVcmIntegrator>(scene, options);
}

}  // namespace metrolux::core
