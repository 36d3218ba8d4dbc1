#include "integrators/description.h"
#include "integrators/iteration.h"
#include "integrators/path_chains.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

/// Primary sample space Metropolis light transport [Kel02]: chains over the random numbers of bidirectional
/// path tracing, one eye and one light subpath in each step, target the luminance of all that they
/// contribute.
class PssmltIntegrator final : public Resumable<PssmltIntegrator> {
  public:
    PssmltIntegrator(const Scene& scene, const CommonOptions& options, const MetropolisParameters& parameters)
        : scene_(scene),
          options_(options),
          pixels_(hilbertOrder(scene.camera().window().width, scene.camera().window().height)),
          sampler_(pathSamplerOptions(options.seed, parameters, pixels_.size(), 0)) {}

    void addPass(Film& film, uint32_t pass) override {
        const Strategies strategies = Strategies::bidirectional(1, 0);
        directPass({scene_, options_.limits, strategies, nonFinite_, options_.seed, pass}, pixels_, film);
        const PathPair pair{scene_, options_.limits, strategies, film, nonFinite_};
        sampler_.integrate(pixels_.size(), evaluatorOf(pair), payTo(film));
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(sampler_);
        checkPixels(sampler_, scene_.camera().window());
    }
    nlohmann::json statistics() const override { return samplerStatistics(sampler_); }
    std::string progressNote() const override { return acceptanceNote(sampler_.counts()); }

  private:
    const Scene& scene_;
    CommonOptions options_;
    std::vector<uint32_t> pixels_;
    PathSampler sampler_;
};

}  // namespace

IntegratorDescription pssmltIntegrator() {
    return describe<MetropolisParameters, PssmltIntegrator>(
        "pssmlt", "primary sample space Metropolis light transport on bidirectional path tracing");
}

}  // namespace metrolux::core
