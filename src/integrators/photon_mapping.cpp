#include "integrators/photon_mapping.h"

#include "integrators/light_subpath_chains.h"
#include "integrators/resumable.h"

#include <optional>

namespace metrolux::core {

namespace {

/// Each path has one vertex, the first from the camera that scatters it by a smooth lobe, where a photon can
/// make it, or none, and then hit makes it (Strategies::MergeAt::FirstVertex).
class PhotonMappingIntegrator final : public Resumable<PhotonMappingIntegrator, IteratedIntegrator> {
  public:
    PhotonMappingIntegrator(const Scene& scene, const IntegratorOptions& options, bool chains)
        : Resumable(scene, options, projectedPixelRadius(scene, options)) {
        if (chains)
            chains_.emplace(
                replicaSettings(options, "uv", MutationKernel::Kind::Adaptive, partition_.pixels(0).size()),
                options.limits);
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
    void iterate(Film& film, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size()), r = radius_.radius();
        const Strategies strategies = Strategies::photonMapping();
        traceEyes(strategies, pixels, film);
        grid_.build(eyes_.all(), static_cast<float>(r));

        const LightSubpathPass lightPass{scene_, options_.limits, strategies, eyes_, grid_, film};
        const LightSubpathIteration iteration{film.passIndex(), first, pixels.size(), n / film.pixelCount()};
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

std::unique_ptr<Integrator> makeSppmIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<PhotonMappingIntegrator>(scene, options, false);
}

std::unique_ptr<Integrator> makeVptIntegrator(const Scene& scene, const IntegratorOptions& options) {
    return std::make_unique<PhotonMappingIntegrator>(scene, options, true);
}

}  // namespace metrolux::core
