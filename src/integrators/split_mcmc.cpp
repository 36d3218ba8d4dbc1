#include "integrators/split_mcmc.h"

#include "integrators/eye_chains.h"
#include "integrators/resumable.h"

namespace metrolux::core {

namespace {

class SplitMcmcIntegrator final : public Resumable<SplitMcmcIntegrator, IteratedIntegrator> {
  public:
    SplitMcmcIntegrator(const Scene& scene, const IntegratorOptions& options)
        : Resumable(scene, options, projectedPixelRadius(scene, options)),
          light_(settings(), options.limits),
          eye_(settings(), scene.camera().window()) {
        light_.keepTrails = true;
        weighByPhotons();
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
        archive(light_, eye_, lightVertices_);
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = light_.statistics();
        j.update(iterationStatistics());
        j["stored_bytes"] = j["stored_bytes"].get<size_t>() + oldGrid_.memoryBytes();
        j["eye_chains"] = eye_.statistics();
        j["light_vertices"] = lightVertices_.size();
        return j;
    }
    std::string progressNote() const override { return light_.progressNote(); }

  private:
    ReplicaSettings settings() const {
        return replicaSettings(options_, "uv", MutationKernel::Kind::Adaptive, partition_.pixels(0).size());
    }

    /// Per light subpath, with boosts q_E and q_L of eye and light subpaths' densities: n_E q_E hits and nee,
    /// q_E q_L connections, q_L splats and n_E q_E q_L pi r^2 merges; divided by those of connections.
    Strategies strategies(double eyeSamples, double eyeBoost) const {
        const double r = radius_.radius();
        return Strategies::bidirectional(light_.effectiveSamples() / eyeSamples,
                                         eyeSamples * std::numbers::pi * r * r, photons_.get(), 1 / eyeBoost);
    }

    void iterate(Film& film, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size());
        const float r = static_cast<float>(radius_.radius());
        const LightSubpathIteration iteration{film.passIndex(), first, pixels.size(), n / film.pixelCount()};
        const bool chains = !lightVertices_.empty();
        light_.begin(pixels.size(), radius_.radius());
        if (chains) eye_.begin(pixels.size(), radius_.radius());
        const Strategies counts = chains ? strategies(eye_.samples(), eye_.boost()) : strategies(n, 1);

        if (chains) {
            oldGrid_.buildPoints(lightVertices_, r);
            eye_.run(eyePass(counts, film), oldGrid_, film, iteration, eyes_);
        } else {
            traceEyes(counts, pixels, film);
        }
        grid_.build(eyes_.all(), r);
        light_.run({scene_, options_.limits, counts, eyes_, grid_, film}, film, iteration, photons_.get());
        lightVertices_ = light_.trails();
    }

    LightSubpathChains light_;
    EyeChains eye_;
    std::vector<Vec3f> lightVertices_;  ///< of the last iteration
    VertexGrid oldGrid_;                ///< over them
};

}  // namespace

std::unique_ptr<Integrator> makeSplitMcmcIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<SplitMcmcIntegrator>(scene, options);
}

}  // namespace metrolux::core
