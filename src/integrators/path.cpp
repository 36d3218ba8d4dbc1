#include "integrators/description.h"
#include "integrators/iteration.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

/// Unidirectional path tracing: hit and next-event estimation, balance heuristic.
class PathIntegrator final : public Resumable<PathIntegrator> {
  public:
    PathIntegrator(const Scene& scene, const CommonOptions& options, const NoParameters&)
        : scene_(scene),
          options_(options),
          pixels_(hilbertOrder(scene.camera().window().width, scene.camera().window().height)) {}

    void addPass(Film& film, uint32_t pass) override {
        Strategies strategies = Strategies::path();
        strategies.wavelength = wavelengthOf(scene_, options_.seed, pass);
        EyeVertices none;
        wavefronts_.run({scene_, options_.limits, strategies, nonFinite_, options_.seed, pass}, pixels_, film,
                        none);
    }
    template <class Archive>
    void serialize(Archive&) {}  // the number of the pass is all
    nlohmann::json statistics() const override { return nlohmann::json::object(); }

  private:
    const Scene& scene_;
    CommonOptions options_;
    std::vector<uint32_t> pixels_;
    EyeWavefronts wavefronts_;
};

/// Light tracing: every light vertex is connected to the camera; emitters seen directly are hit by eye rays.
/// Cannot see what the camera sees through delta lobes only.
class LightIntegrator final : public Resumable<LightIntegrator> {
  public:
    LightIntegrator(const Scene& scene, const CommonOptions& options, const NoParameters&)
        : scene_(scene),
          options_(options),
          pixels_(hilbertOrder(scene.camera().window().width, scene.camera().window().height)) {}

    void addPass(Film& film, uint32_t pass) override {
        Strategies strategies = Strategies::splatsAlone();
        strategies.wavelength = wavelengthOf(scene_, options_.seed, pass);
        directPass({scene_, options_.limits, strategies, nonFinite_, options_.seed, pass}, pixels_, film);
        const EyeVertices none;
        const VertexGrid grid;
        const LightSubpathPass lightPass{scene_, options_.limits, strategies, none, grid, nonFinite_};
        independentLightSubpaths(lightPass, film, options_.seed, {pass, 0, pixels_.size()});
    }
    template <class Archive>
    void serialize(Archive&) {}  // the number of the pass is all
    nlohmann::json statistics() const override { return nlohmann::json::object(); }

  private:
    const Scene& scene_;
    CommonOptions options_;
    std::vector<uint32_t> pixels_;
};

}  // namespace

IntegratorDescription pathIntegrator() {
    return describe<NoParameters, PathIntegrator>("path", "path tracing with next-event estimation",
                                                  {"direct", "volpath", "volpathmis", "volpath_simple"});
}

IntegratorDescription lightIntegrator() {
    return describe<NoParameters, LightIntegrator>(
        "light", "light tracing: light subpaths connected to the camera", {"ptracer"});
}

}  // namespace metrolux::core
