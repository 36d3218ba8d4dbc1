#include "integrators/description.h"
#include "integrators/iteration.h"
#include "integrators/resumable.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

struct VcmParameters {
    MergingParameters merging;
    MediumMergingParameters inMedia;
    WeighingParameters weighing;
    VarianceParameters variance;
    ConnectionParameters connections;
    template <class V>
    void visit(V&& v) {
        v(merging);
        v(inMedia);
        v(weighing);
        v(variance);
        v(connections);
    }
};

/// Vertex connection and merging [Geo12, HPJ12]: all techniques of docs/explain/algorithm.md section 1,
/// independent light subpaths. Without merging it is bidirectional path tracing [VG94, VG95].
class VcmIntegrator final : public Resumable<VcmIntegrator, IteratedIntegrator> {
  public:
    VcmIntegrator(const Scene& scene, const CommonOptions& options, const VcmParameters& parameters)
        : Resumable(scene, options, parameters.merging),
          connections_(parameters.connections.connections),
          merge_(true) {
        mergeInMedia(parameters.inMedia);
        weighByPhotons(parameters.weighing);
        weighByVariance(parameters.variance);
    }
    VcmIntegrator(const Scene& scene, const CommonOptions& options, const ConnectionParameters& parameters)
        : Resumable(scene, options, MergingParameters{0}),
          connections_(parameters.connections),
          merge_(false) {}

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
    }
    nlohmann::json statistics() const override { return iterationStatistics(); }

  private:
    void iterate(Film& film, uint32_t pass, std::span<const uint32_t> pixels, size_t first) override {
        const double n = double(pixels.size());
        Strategies strategies = Strategies::bidirectional(1, 0, photons_.get());
        if (merge_) countMerges(n, strategies);
        strategies.eyeFactors = eyeFactors_.get();
        strategies.connect = connections_;
        strategies.wavelength = wavelength(pass);
        traceEyes(eyePass(strategies, pass), pixels, film);
        if (merge_) sortEyes();

        independentLightSubpaths(lightSubpathPass(strategies), film, options_.seed,
                                 {pass, first, pixels.size(), n / film.pixelCount()}, photons_.get());
        if (photons_) photons_->endIteration(n);
    }

    double connections_;
    bool merge_;
};

}  // namespace

IntegratorDescription vcmIntegrator() {
    return describe<VcmParameters, VcmIntegrator>(
        "vcm", "vertex connection and merging, independent light subpaths");
}

IntegratorDescription bdptIntegrator() {
    return describe<ConnectionParameters, VcmIntegrator>("bdpt", "bidirectional path tracing");
}

}  // namespace metrolux::core
