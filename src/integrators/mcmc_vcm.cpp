#include "integrators/mcmc_vcm.h"

#include "integrators/light_chains.h"

#include <memory>

namespace metrolux {

namespace {

class McmcVcmIntegrator final : public Integrator {
  public:
    McmcVcmIntegrator(const Scene& scene, const IntegratorOptions& options)
        : scene_(scene),
          options_(options),
          partition_(scene.camera().window(), options),
          radius_(projectedPixelRadius(scene, options), options.radiusAlpha),
          chains_(replicaSettings(options, "uvf", MutationKernel::Kind::Kelemen, partition_.pixels(0).size()),
                  options.limits) {
        if (options.correlationAware)
            photons_ = std::make_unique<PhotonDensity>(kPhotonCell * radius_.radius());
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

    nlohmann::json statistics() const override {
        nlohmann::json j = chains_.statistics();
        j.update({{"radius", radius_.radius()},
                  {"parts", partition_.parts()},
                  {"bytes_per_vertex", sizeof(Vertex)},
                  {"stored_bytes", eyes_.memoryBytes() + grid_.memoryBytes()}});
        return j;
    }
    std::string progressNote() const override { return chains_.progressNote(); }

  private:
    void iterate(Film& film, std::span<const uint32_t> pixels, size_t first) {
        const double n = double(pixels.size()), r = radius_.radius();
        chains_.begin(pixels.size(), r);
        const Strategies strategies = Strategies::bidirectional(chains_.effectiveSamples() / n,
                                                                n * std::numbers::pi * r * r, photons_.get());
        EyePass{scene_, options_.limits, strategies, options_.seed, film.passes()}.run(pixels, film, eyes_);
        grid_.build(eyes_.all(), static_cast<float>(r));
        chains_.run({scene_, options_.limits, strategies, eyes_, grid_, film}, film,
                    {film.passes(), first, pixels.size(), n / film.pixelCount()}, photons_.get());
    }

    const Scene& scene_;
    IntegratorOptions options_;
    PixelPartition partition_;
    RadiusSchedule radius_;
    LightChains chains_;
    std::unique_ptr<PhotonDensity> photons_;  ///< null: not options.correlationAware
    EyeVertices eyes_;
    VertexGrid grid_;
};

}  // namespace

std::unique_ptr<Integrator> makeMcmcVcmIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<McmcVcmIntegrator>(scene, options);
}

}  // namespace metrolux
