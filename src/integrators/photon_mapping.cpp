#include "integrators/description.h"
#include "integrators/light_subpath_chains.h"
#include "integrators/resumable.h"

#include <optional>

namespace metrolux::core {

namespace {

struct SppmParameters {
    MergingParameters merging;
    MediumMergingParameters inMedia{.always = true};
    template <class V>
    void visit(V&& v) {
        v(merging);
        v(inMedia);
    }
};

struct VptParameters {
    MergingParameters merging;
    MediumMergingParameters inMedia{.always = true};
    ReplicaParameters replicas{.possible = "uv", .chains = {MutationKernel::Kind::Adaptive}};
    template <class V>
    void visit(V&& v) {
        v(merging);
        v(inMedia);
        v(replicas);
    }
};

/// Stochastic progressive photon mapping [Hachisuka & Jensen 2009], in the formulation of [Knaus & Zwicker
/// 2011] (one radius for all pixels, RadiusSchedule). At the first vertex of an eye subpath that has a smooth
/// lobe, all light that this lobe scatters is estimated from photons, direct light included; emitters are
/// seen directly and over delta lobes. With chains it is visibility-driven photon tracing [HJ11]: light
/// subpaths are from the uniform and the visibility replica.
///
/// Each path has one vertex, the first from the camera that scatters it by a smooth lobe, where a photon can
/// make it, or none, and then hit makes it (Strategies::MergeAt::FirstVertex).
class PhotonMappingIntegrator final : public Resumable<PhotonMappingIntegrator, IteratedIntegrator> {
  public:
    PhotonMappingIntegrator(const Scene& scene, const CommonOptions& options,
                            const SppmParameters& parameters)
        : Resumable(scene, options, parameters.merging) {
        mergeInMedia(parameters.inMedia);
    }
    PhotonMappingIntegrator(const Scene& scene, const CommonOptions& options, const VptParameters& parameters)
        : Resumable(scene, options, parameters.merging) {
        mergeInMedia(parameters.inMedia);
        chains_.emplace(replicaSettings(options.seed, parameters.replicas, partition_.pixels(0).size()));
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
        if (chains_) archive(*chains_);
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = chains_ ? chains_->statistics() : nlohmann::json::object();
        j.update(iterationStatistics());
        return j;
    }
    std::string progressNote() const override { return chains_ ? chains_->progressNote() : std::string(); }

  private:
    void iterate(Film& film, uint32_t pass, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size()), r = radius_.radius();
        Strategies strategies = Strategies::photonMapping();
        strategies.wavelength = wavelength(pass);
        traceEyes(eyePass(strategies, pass), pixels, film);
        sortEyes();

        const LightSubpathPass lightPass = lightSubpathPass(strategies);
        const LightSubpathIteration iteration{pass, first, pixels.size(), n / film.pixelCount()};
        if (chains_) {
            chains_->begin(pixels.size(), r);
            chains_->run(lightPass, film, iteration, nullptr);
        } else {
            independentLightSubpaths(lightPass, film, options_.seed, iteration);
        }
    }

    std::optional<LightSubpathChains> chains_;  ///< vpt
};

}  // namespace

IntegratorDescription sppmIntegrator() {
    return describe<SppmParameters, PhotonMappingIntegrator>("sppm", "stochastic progressive photon mapping",
                                                             {"ppm", "photonmapper"});
}

IntegratorDescription vptIntegrator() {
    return describe<VptParameters, PhotonMappingIntegrator>(
        "vpt", "photon mapping whose photons are driven to where the camera sees them");
}

}  // namespace metrolux::core
