#include "integrators/pssmlt.h"

#include "integrators/iteration.h"
#include "integrators/path_chains.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

class PssmltIntegrator final : public Resumable<PssmltIntegrator> {
  public:
    PssmltIntegrator(const Scene& scene, const IntegratorOptions& options)
        : scene_(scene),
          options_(options),
          pixels_(hilbertOrder(scene.camera().window().width, scene.camera().window().height)),
          sampler_(pathSamplerOptions(options, pixels_.size(), 0)) {}

    void renderPass(Film& film) override {
        directPass(scene_, options_.limits, options_.seed, pixels_, film);
        const Strategies strategies = Strategies::bidirectional(1, 0);
        const PathPair pair{scene_, options_.limits, strategies, film};
        sampler_.integrate(pixels_.size(), evaluatorOf(pair), payTo(film));
        film.endPass();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(sampler_);
        checkPixels(sampler_, scene_.camera().window());
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = chainStatistics(options_);
        j.update(samplerStatistics(sampler_));
        return j;
    }
    std::string progressNote() const override { return acceptanceNote(sampler_.counts()); }

  private:
    const Scene& scene_;
    IntegratorOptions options_;
    std::vector<uint32_t> pixels_;
    PathSampler sampler_;
};

}  // namespace

std::unique_ptr<Integrator> makePssmltIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<PssmltIntegrator>(scene, options);
}

}  // namespace metrolux::core
