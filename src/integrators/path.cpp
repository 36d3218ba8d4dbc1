#include "integrators/path.h"

#include "integrators/iteration.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

/// `path`: hit and next-event estimation. `light`: splats, and emitters that the camera sees directly.
class PathIntegrator final : public Resumable<PathIntegrator> {
  public:
    PathIntegrator(const Scene& scene, const IntegratorOptions& options)
        : scene_(scene),
          options_(options),
          pixels_(hilbertOrder(scene.camera().window().width, scene.camera().window().height)) {}

    void renderPass(Film& film) override {
        const Strategies strategies = Strategies::path();
        EyeVertices none;
        wavefronts_.run({scene_, options_.limits, strategies, options_.seed, film.passIndex()}, pixels_, film,
                        none);
        film.endPass();
    }
    template <class Archive>
    void serialize(Archive&) {}  // the film's count of passes is all
    nlohmann::json statistics() const override { return nlohmann::json::object(); }

  private:
    const Scene& scene_;
    IntegratorOptions options_;
    std::vector<uint32_t> pixels_;
    EyeWavefronts wavefronts_;
};

class LightIntegrator final : public Resumable<LightIntegrator> {
  public:
    LightIntegrator(const Scene& scene, const IntegratorOptions& options)
        : scene_(scene),
          options_(options),
          pixels_(hilbertOrder(scene.camera().window().width, scene.camera().window().height)) {}

    void renderPass(Film& film) override {
        directPass(scene_, options_.limits, options_.seed, pixels_, film);
        const EyeVertices none;
        const VertexGrid grid;
        const Strategies strategies = Strategies::splatsAlone();
        const LightSubpathPass lightPass{scene_, options_.limits, strategies, none, grid, film};
        independentLightSubpaths(lightPass, film, options_.seed, {film.passIndex(), 0, pixels_.size()});
        film.endPass();
    }
    template <class Archive>
    void serialize(Archive&) {}  // the film's count of passes is all
    nlohmann::json statistics() const override { return nlohmann::json::object(); }

  private:
    const Scene& scene_;
    IntegratorOptions options_;
    std::vector<uint32_t> pixels_;
};

}  // namespace

std::unique_ptr<Integrator> makePathIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<PathIntegrator>(scene, options);
}

std::unique_ptr<Integrator> makeLightIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<LightIntegrator>(scene, options);
}

}  // namespace metrolux::core
