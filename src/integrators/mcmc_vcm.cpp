#include "integrators/description.h"
#include "integrators/light_subpath_chains.h"
#include "integrators/light_subpath_choice.h"
#include "integrators/light_subpath_noise.h"
#include "integrators/pass_noise.h"
#include "integrators/resumable.h"

namespace metrolux::core {

namespace {

/// Kernel, replicas and all that steers them, and merging as in vcm.
struct McmcVcmParameters {
    /// Target F of the contribution replica.
    enum class Target {
        Luminance,  ///< what a light subpath adds to the image
        Relative    ///< the same over what the image shows there (PixelImportance)
    };
    MergingParameters merging;
    MediumMergingParameters inMedia;
    WeighingParameters weighing;
    VarianceParameters variance;
    double connections = 0;  ///< as ConnectionParameters; 0: kChainConnections or kIndependentConnections
    ReplicaParameters replicas{"uvf"};
    Target target = Target::Luminance;
    NormalizationMethod normalization = NormalizationMethod::Pooled;
    bool fixed = false;

    template <class V>
    void visit(V&& v) {
        v(merging);
        v(inMedia);
        v(weighing);
        v(variance);
        v("connections", connections,
          Range::between(0, 1).zeroIs("1/64 of those from chains, all independent ones"),
          "share of the light subpaths that are connected with an eye subpath; changes noise alone");
        v(replicas);
        v("target", target,
          Choices<Target>{{{"luminance", Target::Luminance}, {"relative", Target::Relative}}},
          "what chains of f look for; relative: to what the image shows there so far");
        v({"normalization", "normalisation"}, normalization,
          Choices<NormalizationMethod>{
              {{"pooled", NormalizationMethod::Pooled}, {"bennett", NormalizationMethod::Bennett}}},
          "of f: from samples of u and v, or from all by Bennett's ratio; changes noise alone");
        v("fixed", fixed, Flag{},
          "always chains, weighted by what is visible: nothing is chosen by the noise so far");
    }
};

/// Share of the light subpaths that are connected with an eye subpath. Connections cost as much as all else
/// that a light subpath does, and where chains find the light that is hard to find, merging carries most of
/// it: these shares have the smallest error in the same time on most of the scenes of docs/lab/results.md
/// ("Connections"). Where chains are no help, connections are.
constexpr double kChainConnections = 1.0 / 64, kIndependentConnections = 1;

ReplicaSettings settingsOf(uint64_t seed, const McmcVcmParameters& parameters, size_t samples) {
    ReplicaSettings settings = replicaSettings(seed, parameters.replicas, samples);
    settings.normalization = parameters.normalization;
    return settings;
}

/// Whether eye subpaths can find all that light subpaths carry: light of a lamp without extent that has been
/// reflected or refracted by a mirror or glass can only be found from the lamp.
bool eyeSubpathsFindAll(const Scene& scene) {
    bool delta = false;
    for (const LightPtr& light : scene.lights()) {
        if (!light->isConnectable()) return false;
        delta |= light->isDelta();
    }
    if (!delta) return true;
    const auto specular = [](const ShapePtr& shape) { return shape->bsdf && shape->bsdf->hasDeltaLobe(); };
    const SceneParts& parts = scene.parts();
    return std::none_of(parts.shapes.begin(), parts.shapes.end(), specular) &&
           std::none_of(parts.instances.begin(), parts.instances.end(), [&](const Instance& instance) {
               return std::any_of(instance.group->shapes.begin(), instance.group->shapes.end(), specular);
           });
}

/// Vertex connection and merging whose light subpaths come from Markov chains (Sik, Otsu, Hachisuka, Krivanek
/// 2016; docs/explain/algorithm.md, section 3). Eye subpaths are stratified Monte Carlo.
class McmcVcmIntegrator final : public Resumable<McmcVcmIntegrator, IteratedIntegrator> {
  public:
    McmcVcmIntegrator(const Scene& scene, const CommonOptions& options, const McmcVcmParameters& parameters)
        : Resumable(scene, options, parameters.merging),
          parameters_(parameters),
          chains_(settingsOf(options.seed, parameters, partition_.pixels(0).size())),
          choosing_(!parameters.fixed && parameters.replicas.replicas == parameters.replicas.possible),
          choice_(choosing_ && parameters.variance.varianceAware && eyeSubpathsFindAll(scene)) {
        chains_.measureDensity = !parameters.fixed;
        mergeInMedia(parameters.inMedia);
        weighByPhotons(parameters.weighing);
        weighByVariance(parameters.variance);
        if (choosing_ || relative() || parameters.replicas.split.measured)
            image_ = std::make_unique<OwnImage>(scene.camera().window());
        if (choosing_) lightNoise_ = std::make_unique<LightSubpathNoise>(image_->sums().size());
        if (choice_.noneMayDo()) noise_ = std::make_unique<PassNoise>(image_->sums().size());
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeIteration(archive);
        archive(chains_, choice_, surprise_, verdict_);
        if (image_) archive(*image_);
        if (lightNoise_) archive(*lightNoise_);
        if (noise_) archive(*noise_);
    }
    nlohmann::json statistics() const override {
        nlohmann::json j = chains_.statistics();
        j.update(iterationStatistics());
        j["light_subpaths"] = nameOf(lightSubpaths());
        j["boost"] = chains_.density().ofShared() / samples();
        if (lightNoise_) j["gain_of_chains"] = lightNoise_->gain();
        if (noise_)
            j["eye_subpaths_alone"] = {{"noise", verdict_.aloneNoise},
                                       {"noise_with_light_subpaths", verdict_.noise},
                                       {"all_noise", verdict_.aloneAllNoise},
                                       {"all_noise_with_light_subpaths", verdict_.allNoise},
                                       {"surprise", verdict_.surprise.alone},
                                       {"surprise_with_light_subpaths", verdict_.surprise.together},
                                       {"time_over_that_with_light_subpaths", verdict_.eyeShare}};
        return j;
    }
    std::string progressNote() const override {
        return fmt::format("{}, light subpaths: {}", chains_.progressNote(), nameOf(lightSubpaths()));
    }

  private:
    void iterate(Film& film, uint32_t pass, std::span<const uint32_t> pixels, size_t first) override {
        if (first == 0) beginPass();
        const LightSubpaths kind = lightSubpaths();
        if (kind == LightSubpaths::None) return eyesAlone(film, pass, pixels);

        const bool chains = kind == LightSubpaths::Chains;
        const double n = double(pixels.size());
        chains_.begin(pixels.size(), radius_.radius(), chains);
        Strategies strategies = Strategies::bidirectional(chains_.effectiveSamples() / n, 0, photons_.get());
        countMerges(n, strategies);
        strategies.eyeFactors = eyeFactors_.get();
        strategies.connect = parameters_.connections;
        if (!(strategies.connect > 0))
            strategies.connect = chains ? kChainConnections : kIndependentConnections;
        strategies.wavelength = wavelength(pass);
        traceEyes(eyePass(strategies, pass), pixels, film);
        sortEyes();
        LightSubpathPass light = lightSubpathPass(strategies);
        LightSubpathIteration iteration{pass, first, pixels.size(), n / film.pixelCount()};
        if (relative()) iteration.target = &importance_;
        if (noiseIsWeighed()) iteration.noise = &noiseImportance_;
        TechniqueWork work;
        if (noise_ && noise_->open()) {
            light.work = &work;
            if (chains) light.tail = &noise_->tail();
        }
        const bool judged = judgingChains() && chainsTakePart_;
        if (judged) lightNoise_->beginIteration(film);
        chains_.run(light, film, iteration, photons_.get());
        if (judged) lightNoise_->endIteration(film, chains_.squares(), n);
        if (noise_ && noise_->open()) {
            work_.add({eyes_.all().size(), work.splats, work.connections, work.merges});
            if (chains) surprise_ += chains_.surprise();
        }
    }

    void beginPass() {
        if (relative()) importance_.update(*image_, PixelImportance::kDarkestOfTarget);
        if (noiseIsWeighed()) noiseImportance_.update(*image_, PixelImportance::kDarkestOfNoise);
        chainsTakePart_ = chains_.ready();
        if (!noise_ || !chainsTakePart_ || !judging()) return;
        noise_->begin(*eyeFactors_, noiseImportance_, static_cast<uint8_t>(lightSubpaths()),
                      partition_.parts());
        work_ = {};
        if (judgingChains()) surprise_ = {};
    }
    void endPass(const Film& film) override {
        if (image_) image_->addPass(film);
        if (noise_) noise_->addEyes(*eyeFactors_);
        if (noise_ && noise_->open()) noise_->close(*image_, work_);
        if (!choosing_ || !chainsTakePart_) return;
        const bool judgedChains = judgingChains();
        if (judgedChains) lightNoise_->endPass(noiseImportance_);
        choice_.endPass(lightNoise_->gain(), [&] {
            noiseImportance_.update(*image_, PixelImportance::kDarkestOfNoise);
            verdict_ = noise_->verdict(*image_, noiseImportance_, choice_.chosen() != LightSubpaths::None,
                                       surprise_);
            return verdict_.lossOfAlone();
        });
        if (judgedChains && !judgingChains()) lightNoise_->end();
        if (!noise_ || judging()) return;
        noise_->end();
        if (choice_.halfWay()) noise_->noteHalf(*image_);
    }

    void eyesAlone(Film& film, uint32_t pass, std::span<const uint32_t> pixels) {
        Strategies strategies = Strategies::path();
        strategies.wavelength = wavelength(pass);
        traceEyes(eyePass(strategies, pass), pixels, film);
    }

    /// Light subpaths of an iteration.
    double samples() const { return double(partition_.pixels(0).size()); }
    LightSubpaths lightSubpaths() const { return choosing_ ? choice_.next() : LightSubpaths::Chains; }
    bool judging() const { return choosing_ && choice_.judging(); }
    bool judgingChains() const { return judging() && lightSubpaths() == LightSubpaths::Chains; }
    /// Whether the iterations of this pass weigh what their light subpaths add as noise.
    bool noiseIsWeighed() const { return parameters_.replicas.split.measured || judging(); }
    bool relative() const { return parameters_.target == McmcVcmParameters::Target::Relative; }
    static const char* nameOf(LightSubpaths kind) {
        switch (kind) {
            case LightSubpaths::Chains:
                return "chains";
            case LightSubpaths::Independent:
                return "independent";
            case LightSubpaths::None:
                break;
        }
        return "none";
    }

    McmcVcmParameters parameters_;
    LightSubpathChains chains_;
    bool choosing_;
    LightSubpathChoice choice_;
    bool chainsTakePart_ = false;                    ///< or may, in the pass under way
    std::unique_ptr<OwnImage> image_;                ///< null where nothing is decided by it
    std::unique_ptr<LightSubpathNoise> lightNoise_;  ///< null where nothing is chosen
    std::unique_ptr<PassNoise> noise_;               ///< null where there is no choice of none
    PassNoise::Verdict verdict_;                     ///< the last one
    PassWork work_;                                  ///< of the judged pass
    Surprise surprise_;                              ///< of the last judged pass of chains
    PixelImportance importance_;                     ///< of the target
    PixelImportance noiseImportance_;
};

}  // namespace

IntegratorDescription mcmcVcmIntegrator() {
    return describe<McmcVcmParameters, McmcVcmIntegrator>(
        "mcmc_vcm", "VCM whose light subpaths come from Markov chains (default; robust on hard light)",
        {"mlt"});
}

}  // namespace metrolux::core
