#include "integrators/vcm.h"

#include "integrators/iteration.h"

#include <nlohmann/json.hpp>

#include <memory>

namespace metrolux {

namespace {

class VcmIntegrator final : public Integrator {
  public:
    VcmIntegrator(const Scene& scene, const IntegratorOptions& options, bool merge)
        : scene_(scene),
          options_(options),
          merge_(merge),
          partition_(scene.camera().window(), options),
          radius_(merge ? projectedPixelRadius(scene, options) : 0, options.radiusAlpha) {
        if (merge && options.correlationAware)
            photons_ = std::make_unique<PhotonDensity>(kPhotonCell * radius_.radius());
    }

    void renderPass(Film& film) override {
        size_t first = 0;
        for (int part = 0; part < partition_.parts(); ++part) {
            const std::span<const uint32_t> pixels = partition_.pixels(part);
            const double n = double(pixels.size()), r = radius_.radius();
            const Strategies strategies =
                Strategies::bidirectional(1, merge_ ? n * std::numbers::pi * r * r : 0, photons_.get());
            EyePass{scene_, options_.limits, strategies, options_.seed, film.passes()}.run(pixels, film,
                                                                                           eyes_);
            if (merge_) grid_.build(eyes_.all(), static_cast<float>(r));

            LightPass pass{scene_, options_.limits, strategies, eyes_, grid_, film};
            pass.merge = merge_;
            plainLightPass(pass, film, options_.seed, film.passes(), first, pixels.size(),
                           n / film.pixelCount(), nullptr, photons_.get());
            if (photons_) photons_->endIteration(n);
            first += pixels.size();
        }
        film.endPass();
        radius_.advance();
    }

    nlohmann::json statistics() const override {
        nlohmann::json j{{"parts", partition_.parts()},
                         {"bytes_per_vertex", sizeof(Vertex)},
                         {"stored_bytes", eyes_.memoryBytes() + grid_.memoryBytes()}};
        if (merge_) j["radius"] = radius_.radius();
        return j;
    }

  private:
    const Scene& scene_;
    IntegratorOptions options_;
    bool merge_;
    PixelPartition partition_;
    RadiusSchedule radius_;
    std::unique_ptr<PhotonDensity> photons_;
    EyeVertices eyes_;
    VertexGrid grid_;
};

}  // namespace

std::unique_ptr<Integrator> makeVcmIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<VcmIntegrator>(scene, options, true);
}

std::unique_ptr<Integrator> makeBdptIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<VcmIntegrator>(scene, options, false);
}

}  // namespace metrolux
