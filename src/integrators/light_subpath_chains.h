#pragma once
/// Light subpaths from Markov chains: the light pass that mcmc_vcm, vpt and split_mcmc share.

#include "integrators/iteration.h"
#include "markov/mixture_density.h"
#include "markov/replica_lanes.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

/// Visible uniform samples that b_V is to rest on before chains take part.
inline constexpr double kVisibleSamples = 256;

/// What the primary sample of a light subpath evaluates to.
struct LightSubpathContribution {
    SplatList splats;
    std::vector<Vec3f> trail;  ///< its smooth vertices, if LightSubpathChains::keepTrails
    double size = 0;           ///< F(u)
    double squares = 0;        ///< of its splats, relative to the image where that is known
    bool visible() const { return size > 0; }
};

/// `samples` in an iteration decide about the number of lanes. Throws Error for a measured split without the
/// contribution replica.
ReplicaSettings replicaSettings(uint64_t seed, const ReplicaParameters& parameters, size_t samples);

/// Statistics of a set of lanes, in the form of Integrator::statistics().
nlohmann::json replicaStatistics(const ReplicaSettings& settings, const ReplicaCounts& counts,
                                 const Normalization& normalization);

/// The first passes are made of independent light subpaths, which give the first b_V and b_F; then each
/// iteration's subpaths come from the replicas.
class LightSubpathChains {
  public:
    explicit LightSubpathChains(const ReplicaSettings& settings)
        : lanes_(settings), density_(lanes_.size()), trails_(lanes_.size()), sums_(lanes_.size()) {}

    /// Decides about the samples of the iteration to come, before its weights are known. Without `chains`:
    /// all are independent.
    void begin(size_t samples, double radius, bool chains = true);
    /// M q of that iteration: light subpaths, times their density boost. That of the visibility replica
    /// stands for it (docs/explain/algorithm.md, section 1) until it has been measured where eye subpaths
    /// compete.
    double effectiveSamples() const;
    /// Traces the light subpaths and adds what they contribute to the film. `photons` (may be null) counts
    /// the vertices of the uniform ones.
    void run(const LightSubpathPass& pass, Film& film, const LightSubpathIteration& iteration,
             PhotonDensity* photons);

    /// Whether the chains have taken over from the plain passes.
    bool ready() const { return ready_; }
    /// Positions of the smooth vertices of all light subpaths that the last run() has used. Empty without
    /// keepTrails and for plain passes.
    std::vector<Vec3f> trails() const;
    bool keepTrails = false;
    /// Whether density() is measured, and effectiveSamples() by it.
    bool measureDensity = false;
    const MixtureDensity& density() const { return density_; }
    /// Means over independent light subpaths, from the last iteration of chains: of SplatList::surprise, and
    /// of the squares that a given LightSubpathIteration::noise makes of the splats.
    Surprise surprise() const;
    double squares() const;
    /// Of a lane in an iteration, with the weights of its samples.
    struct Sums {
        Surprise surprise;
        double squares = 0;
    };

    /// Between two iterations.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(lanes_, density_, boostKnown_, ready_);
    }

    nlohmann::json statistics() const;
    std::string progressNote() const;

  private:
    void independentRun(const LightSubpathPass& pass, Film& film, const LightSubpathIteration& iteration,
                        PhotonDensity* photons, std::vector<double>* sizes);
    void plainRun(const LightSubpathPass& pass, Film& film, const LightSubpathIteration& iteration,
                  PhotonDensity* photons);

    ReplicaLanes<LightSubpathContribution> lanes_;
    MixtureDensity density_;
    std::vector<std::vector<Vec3f>> trails_;  ///< of each lane
    std::vector<Sums> sums_;                  ///< of each lane
    ReplicaMixture mix_;
    double squaredRadius_ = 0;
    bool boostKnown_ = false;  ///< b_V, and with it q, is known well enough for weights
    bool ready_ = false;
    bool chainsRun_ = false;  ///< in the iteration of begin()
};

}  // namespace metrolux::core
