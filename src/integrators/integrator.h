#pragma once
#include "base/state.h"
#include "image/film.h"
#include "markov/mutation.h"
#include "markov/normalization.h"
#include "scene/scene.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace metrolux::core {

/// Target F of the contribution replica.
enum class ChainTarget {
    Luminance,  ///< what a light subpath adds to the image
    Relative    ///< the same over what the image shows there (PixelImportance)
};

/// Everything that changes what an integrator computes. Same options, scene and pass count: the same bits.
struct IntegratorOptions {
    uint64_t seed = 0;
    PathLimits limits;
    double radius = 0;          ///< first merging radius in scene units; 0: from the projected pixel size
    double radiusAlpha = 0.75;  ///< [HPJ12] schedule
    size_t memoryBytes = 0;     ///< bound for what a pass stores; 0: no bound
    std::optional<MutationKernel::Kind> kernel;  ///< mutation of the chains; absent: the integrator's own
    double largeStep = 0.3;  ///< pssmlt, mmlt, pssmlt_merge: probability of a uniform proposal
    /// mcmc_vcm: statistical inefficiency g of the chains; a step counts as 1/g sample in all weights. Any
    /// value is unbiased.
    double chainInefficiency = 4;
    bool correlationAware = true;  ///< vcm, mcmc_vcm: Strategies::mergeShare()
    /// bdpt, vcm, mcmc_vcm: share of the light subpaths that are connected with an eye subpath, in (0, 1];
    /// absent: the integrator's own. Any value is unbiased.
    std::optional<double> connections;
    char mergeMethod = 'B';                ///< pssmlt_merge: method of the supplement's 4.1.1, 'B' or 'A'
    int lanes = 0;                         ///< chains: number of independent lanes; 0: default
    std::array<double, 3> split{1, 1, 1};  ///< mcmc_vcm, vpt, split_mcmc: n_U : n_V : n_F
    bool measuredSplit = false;            ///< mcmc_vcm: the split follows the noise that each replica makes
    ChainTarget target = ChainTarget::Luminance;                      ///< mcmc_vcm
    NormalizationMethod normalization = NormalizationMethod::Pooled;  ///< mcmc_vcm: of F
    bool pooledTheta = false;  ///< mcmc_vcm, vpt, split_mcmc: lanes share the adaptive kernel's theta
    /// mcmc_vcm, vpt, split_mcmc: which replicas take part (study of each alone); absent: all of the
    /// integrator's.
    std::optional<std::string> replicas;
};

/// A progressive integrator: an image after each pass (nori's integrator.h, with passes).
class Integrator {
  public:
    virtual ~Integrator() = default;
    /// Adds one pass (one sample, light path or mutation per pixel) to the film and calls film.endPass().
    virtual void renderPass(Film& film) = 0;
    /// Everything that renderPass() changes, between two passes: an integrator of the same scene and options
    /// that loads it goes on bit for bit. loadState() throws Error for what it cannot use. See Resumable.
    virtual void saveState(StateWriter& writer) const = 0;
    virtual void loadState(StateReader& reader) = 0;
    /// What a user may want to know: acceptance rates, normalizations, radius ...
    virtual nlohmann::json statistics() const = 0;
    /// Short text for the progress line, may be empty.
    virtual std::string progressNote() const { return {}; }
};

/// An empty film for the scene's camera.
Film makeFilm(const Scene& scene);

/// Names of all integrators, with a line of description each.
std::vector<std::pair<std::string, std::string>> integratorList();
/// Throws Error for an unknown name, with the nearest known one.
std::unique_ptr<Integrator> makeIntegrator(const std::string& name, const Scene& scene,
                                           const IntegratorOptions& options);

}  // namespace metrolux::core
