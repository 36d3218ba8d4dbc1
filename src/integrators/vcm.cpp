#include "integrators/vcm.h"

#include "integrators/iteration.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

class VcmIntegrator final : public Resumable<VcmIntegrator, IteratedIntegrator> {
  public:
    VcmIntegrator(const Scene& scene, const IntegratorOptions& options, bool merge)
        : Resumable(scene, options, merge ? projectedPixelRadius(scene, options) : 0), merge_(merge) {
        if (merge) weighByPhotons();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
    }
    nlohmann::json statistics() const override { return iterationStatistics(); }

  private:
    void iterate(Film& film, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size()), r = radius_.radius();
        Strategies strategies =
            Strategies::bidirectional(1, merge_ ? n * std::numbers::pi * r * r : 0, photons_.get());
        strategies.connect = options_.connections.value_or(1);
        traceEyes(strategies, pixels, film);
        if (merge_) grid_.build(eyes_.all(), static_cast<float>(r));

        const LightSubpathPass pass{scene_, options_.limits, strategies, eyes_, grid_, film};
        independentLightSubpaths(pass, film, options_.seed,
                                 {film.passIndex(), first, pixels.size(), n / film.pixelCount()},
                                 photons_.get());
        if (photons_) photons_->endIteration(n);
    }

    bool merge_;
};

}  // namespace

std::unique_ptr<Integrator> makeVcmIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<VcmIntegrator>(scene, options, true);
}

std::unique_ptr<Integrator> makeBdptIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<VcmIntegrator>(scene, options, false);
}

}  // namespace metrolux::core
