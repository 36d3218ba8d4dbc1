#pragma once
/// What the pass-based integrators share: which pixels an iteration covers, the merging radius, plain light
/// passes.

#include "image/hilbert_order.h"
#include "integrators/integrator.h"
#include "integrators/parameter_groups.h"
#include "integrators/pixel_importance.h"
#include "transport/eye_pass.h"
#include "transport/light_subpath_pass.h"
#include "wavefront/eye_wavefront.h"

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <span>
#include <vector>

namespace metrolux::core {

/// Splits a pass into iterations whose stored eye vertices fit the memory bound. Each iteration covers a
/// stratified part of the pixels, in the order of a Hilbert curve; together they cover every pixel once.
class PixelPartition {
  public:
    PixelPartition(const FilmWindow& window, const CommonOptions& options);
    int parts() const { return parts_; }
    std::span<const uint32_t> pixels(int part) const {
        return {pixels_.data() + starts_[part], starts_[part + 1] - starts_[part]};
    }

  private:
    int parts_ = 1;
    std::vector<uint32_t> pixels_;
    std::vector<size_t> starts_;
};

/// Progressive radius of [HPJ12]: r_{i+1} = r_i ((i + alpha) / (i + 1))^(1/2), i counted from 1.
class RadiusSchedule {
  public:
    RadiusSchedule(double first, double alpha) : radius_(first), alpha_(alpha) {}
    double radius() const { return radius_; }
    template <class Archive>
    void serialize(Archive& archive) {
        archive(radius_, iteration_);
        checkState(radius_ >= 0 && iteration_ >= 1, "a merging radius");
    }
    void advance() {
        radius_ *= std::sqrt((iteration_ + alpha_) / (iteration_ + 1.0));
        ++iteration_;
    }

  private:
    double radius_, alpha_, iteration_ = 1;
};

/// Edge of a PhotonDensity's cell in first merging radii: a compromise of noise and detail.
inline constexpr double kPhotonCell = 8;

/// The pass of emitters that the camera sees directly (paths of one edge), one eye ray for each of `pixels`:
/// `pass` without its strategies and longer paths, at the wavelength of the pass. Integrators that find all
/// other light by light subpaths or chains add it.
void directPass(const EyePass& pass, std::span<const uint32_t> pixels, Film& film);

/// Number of independent lanes of chains that together take `steps` steps: long chains, and enough of them
/// for many threads. Depends on the image only, or is what the parameters say.
int laneCount(const ChainParameters& chains, size_t steps);

/// The light subpaths of an iteration.
struct LightSubpathIteration {
    uint32_t pass = 0;
    size_t first = 0, count = 0;  ///< index of the first in the pass, and their number
    /// Part of the pass that the iteration stands for: film splats, which any pixel may get, are scaled by
    /// it.
    double filmShare = 1;
    const PixelImportance* target = nullptr;  ///< of F(u); null: all pixels count alike
    const PixelImportance* noise = nullptr;   ///< weighs squares; null: as F(u)
};

/// Traces independent light subpaths and adds them to the film, averaged over their number. Their vertices
/// are `counted`, and `sizes` receives F of each, if given.
void independentLightSubpaths(const LightSubpathPass& pass, Film& film, uint64_t seed,
                              const LightSubpathIteration& iteration, PhotonDensity* counted = nullptr,
                              std::vector<double>* sizes = nullptr);

/// Key of the stream of light subpath `index` of a plain pass.
uint64_t lightSubpathKey(uint64_t seed, uint32_t pass, size_t index);

/// An integrator that stores eye vertices: a pass is made of iterations that fit the memory bound, and the
/// merging radius shrinks after each pass.
class IteratedIntegrator : public Integrator {
  public:
    void addPass(Film& film, uint32_t pass) final;

  protected:
    /// `merging`: of radius 0 without merging.
    IteratedIntegrator(const Scene& scene, const CommonOptions& options, const MergingParameters& merging);
    void mergeInMedia(const MediumMergingParameters& merging) { firstMediumRadius_ = merging.radius; }
    /// Set up photons_ and eyeFactors_ if the parameters ask for them.
    void weighByPhotons(const WeighingParameters& weighing);
    void weighByVariance(const VarianceParameters& variance);

    /// Adds what `pixels` and as many light subpaths, from index `first` of the pass, stand for.
    virtual void iterate(Film& film, uint32_t pass, std::span<const uint32_t> pixels, size_t first) = 0;
    /// All iterations of a pass have been made. The film is not closed yet.
    virtual void endPass(const Film& film) { (void)film; }
    /// Part of the state of each of them.
    template <class Archive>
    void serializeIteration(Archive& archive) {
        archive(radius_);
        if (photons_) archive(*photons_);
        if (eyeFactors_) archive(*eyeFactors_);
    }
    /// Traces an iteration's eye subpaths: eyes_ has their vertices.
    void traceEyes(const EyePass& pass, std::span<const uint32_t> pixels, Film& film) {
        eyeWavefronts_.run(pass, pixels, film, eyes_);
    }
    EyePass eyePass(const Strategies& strategies, uint32_t pass) {
        return {scene_, options_.limits, strategies, nonFinite_, options_.seed, pass, eyeFactors_.get()};
    }
    Wavelength wavelength(uint32_t pass) const { return wavelengthOf(scene_, options_.seed, pass); }
    /// Counts of merging for `samples` eye subpaths (with the boost of their density).
    void countMerges(double samples, Strategies& strategies) const;
    /// Builds grid_ and mediumGrid_ over eyes_.
    void sortEyes();
    /// Over eyes_, grid_ and mediumGrid_.
    LightSubpathPass lightSubpathPass(const Strategies& strategies) {
        LightSubpathPass pass{scene_, options_.limits, strategies, eyes_, grid_, nonFinite_};
        pass.mediumGrid = &mediumGrid_;
        pass.shareInside = shareInside_;
        return pass;
    }
    /// What statistics() says of all of them.
    nlohmann::json iterationStatistics() const;

    const Scene& scene_;
    CommonOptions options_;
    PixelPartition partition_;
    RadiusSchedule radius_;
    std::unique_ptr<PhotonDensity> photons_;  ///< of Strategies; null: merges are weighted as independent
    std::unique_ptr<EyeFactors> eyeFactors_;  ///< of Strategies; null: plain balance heuristic
    EyeWavefronts eyeWavefronts_;
    EyeVertices eyes_;
    VertexGrid grid_;                 ///< of eyes_ on surfaces
    VertexGrid mediumGrid_;           ///< in media
    std::vector<float> shareInside_;  ///< of eyes_; of those in media what shareInside() says

  private:
    double mediumRadius() const;
    double firstRadius_, firstMediumRadius_ = 0;  ///< 0: no merging
};

}  // namespace metrolux::core
