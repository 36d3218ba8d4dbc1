#include "integrators/description.h"
#include "integrators/eye_chains.h"
#include "integrators/resumable.h"

namespace metrolux::core {

namespace {

struct SplitMcmcParameters {
    MergingParameters merging;
    WeighingParameters weighing;
    ReplicaParameters replicas{.possible = "uv", .chains = {MutationKernel::Kind::Adaptive}};
    template <class V>
    void visit(V&& v) {
        v(merging);
        v(weighing);
        v(replicas);
    }
};

/// Vertex connection and merging of eye and light subpaths that each come from visibility-driven chains
/// (supplement of [Sik16], section 4.2). A light subpath is visible if it touches a pixel, an eye subpath if
/// one of its vertices lies within the merging radius of a light vertex of the last iteration.
class SplitMcmcIntegrator final : public Resumable<SplitMcmcIntegrator, IteratedIntegrator> {
  public:
    SplitMcmcIntegrator(const Scene& scene, const CommonOptions& options,
                        const SplitMcmcParameters& parameters)
        : Resumable(scene, options, parameters.merging),
          light_(settings(parameters.replicas)),
          eye_(settings(parameters.replicas), scene.camera().window()) {
        light_.keepTrails = true;
        weighByPhotons(parameters.weighing);
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
    ReplicaSettings settings(const ReplicaParameters& parameters) const {
        return replicaSettings(options_.seed, parameters, partition_.pixels(0).size());
    }

    /// Per light subpath, with boosts q_E and q_L of eye and light subpaths' densities: n_E q_E hits and nee,
    /// q_E q_L connections, q_L splats and n_E q_E q_L pi r^2 merges; divided by those of connections.
    Strategies strategies(double eyeSamples, double eyeBoost) const {
        const double r = radius_.radius();
        return Strategies::bidirectional(light_.effectiveSamples() / eyeSamples,
                                         eyeSamples * std::numbers::pi * r * r, photons_.get(), 1 / eyeBoost);
    }

    void iterate(Film& film, uint32_t pass, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size());
        const float r = static_cast<float>(radius_.radius());
        const LightSubpathIteration iteration{pass, first, pixels.size(), n / film.pixelCount()};
        const bool chains = !lightVertices_.empty();
        light_.begin(pixels.size(), radius_.radius());
        if (chains) eye_.begin(pixels.size(), radius_.radius());
        Strategies counts = chains ? strategies(eye_.samples(), eye_.boost()) : strategies(n, 1);
        counts.wavelength = wavelength(pass);

        if (chains) {
            oldGrid_.build(lightVertices_, r);
            eye_.run(eyePass(counts, pass), oldGrid_, film, iteration, eyes_);
        } else {
            traceEyes(eyePass(counts, pass), pixels, film);
        }
        grid_.build(positionsOf(eyes_.all()), r);
        light_.run(lightSubpathPass(counts), film, iteration, photons_.get());
        lightVertices_ = light_.trails();
    }

    LightSubpathChains light_;
    EyeChains eye_;
    std::vector<Vec3f> lightVertices_;  ///< of the last iteration
    VertexGrid oldGrid_;                ///< over them
};

}  // namespace

IntegratorDescription splitMcmcIntegrator() {
    return describe<SplitMcmcParameters, SplitMcmcIntegrator>(
        "split_mcmc", "VCM with eye and light subpaths from separate visibility-driven chains");
}

}  // namespace metrolux::core
