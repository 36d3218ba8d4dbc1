#pragma once
/// Parameters that several integrators have. A default that differs is set where the group is a member.

#include "base/parameter.h"
#include "markov/mutation.h"
#include "scene/scene.h"

#include <array>

namespace metrolux::core {

/// First merging radius: a multiple of the mean width of a pixel's footprint on the surfaces that the camera
/// sees (through mirrors and glass, at the first smooth surface). Falls back to a fraction of the scene if it
/// sees none.
double projectedPixelRadius(const Scene& scene, const PathLimits& limits);
/// First radius for merging in media: ten eye vertices lie within it on average, if they are as far apart
/// along the rays of the camera as their free flights are long; a quarter of such a flight at most. 0 where
/// the camera sees no medium that scatters.
double projectedMediumRadius(const Scene& scene, const PathLimits& limits);
/// Throws Error for a merging radius that is larger than the scene, which would blur all of it into one, or
/// so small that single precision does not tell points apart at that distance.
void checkRadius(double radius, const Scene& scene);

struct MergingParameters {
    double radius = 0;  ///< scene units; 0: projectedPixelRadius()
    double alpha = 0.75;
    template <class V>
    void visit(V&& v) {
        v({"radius", "initial_radius"}, radius, Range::from(0).zeroIs("from the pixel size"),
          "first merging radius in scene units");
        v({"radius_alpha", "alpha"}, alpha, Range::between(0, 1),
          "how slowly the radius shrinks: r^2 is as passes^(alpha - 1)");
    }
    void resolve(const Scene& scene, const PathLimits& limits) {
        if (radius == 0)
            radius = projectedPixelRadius(scene, limits);
        else
            checkRadius(radius, scene);
    }
};

struct MediumMergingParameters {
    double radius = 0;    ///< scene units; 0: no merging in media, or projectedMediumRadius()
    bool always = false;  ///< the integrator has no other way to scatter in media
    template <class V>
    void visit(V&& v) {
        v({"medium_radius"}, radius,
          Range::from(0).zeroIs(always ? "from the pixel size and the medium" : "off"),
          "first radius for merging in media, in scene units");
    }
    void resolve(const Scene& scene, const PathLimits& limits) {
        if (radius > 0)
            checkRadius(radius, scene);
        else if (always)
            radius = projectedMediumRadius(scene, limits);
    }
};

struct WeighingParameters {
    bool correlationAware = true;  ///< Strategies::mergeShare()
    template <class V>
    void visit(V&& v) {
        v("correlation_aware", correlationAware, Flag{},
          "weigh merges that share an eye vertex as one sample");
    }
};

struct VarianceParameters {
    bool varianceAware = true;  ///< Strategies::eyeFactors
    template <class V>
    void visit(V&& v) {
        v("variance_aware", varianceAware, Flag{},
          "weigh what eye subpaths find alone by its variance in the passes before");
    }
};

struct ConnectionParameters {
    double connections = 1;  ///< any value is unbiased
    template <class V>
    void visit(V&& v) {
        v("connections", connections, Range::between(1e-6, 1),
          "share of the light subpaths that are connected with an eye subpath; changes noise alone");
    }
};

struct ChainParameters {
    MutationKernel::Kind kernel = MutationKernel::Kind::Kelemen;
    int lanes = 0;
    template <class V>
    void visit(V&& v) {
        static const Choices<MutationKernel::Kind> kKernels{
            {{"kelemen", MutationKernel::Kind::Kelemen}, {"adaptive", MutationKernel::Kind::Adaptive}}};
        v("kernel", kernel, kKernels, "mutation of the chains; adaptive makes larger steps");
        v("lanes", lanes, Range::between(0, 1 << 20).zeroIs("by the number of pixels"),
          "number of independent sets of chains");
    }
};

/// Statistical inefficiency g of chains: a step counts as 1/g sample in all weights. Any value is unbiased.
struct InefficiencyParameters {
    double chainInefficiency = 4;
    template <class V>
    void visit(V&& v) {
        v("chain_inefficiency", chainInefficiency, Range::between(1, 1e6),
          "steps of a chain that weigh as much as one independent sample; changes noise alone");
    }
};

/// Chains over complete paths.
struct MetropolisParameters {
    ChainParameters chains;
    double largeStep = 0.3;
    template <class V>
    void visit(V&& v) {
        v(chains);
        v({"large_step", "p_large"}, largeStep, Range::between(0, 1),
          "probability of a step to a uniform sample");
    }
};

/// n_U : n_V : n_F, or as the noise says that each replica makes.
struct ReplicaSplit {
    std::array<double, 3> parts{1, 1, 1};
    bool measured = false;
};

/// Three numbers, or "auto" where the contribution replica is there to be weighed against the others.
struct SplitForm {
    bool mayBeMeasured;
    void read(const ParameterValue& value, ReplicaSplit& to) const;
    ParameterValue write(const ReplicaSplit& split) const;
    void describe(ParameterInfo& info) const;
    std::string expected() const;
};

/// Replicas of light subpaths (markov/replica_lanes.h).
struct ReplicaParameters {
    std::string possible;             ///< letters of the replicas that the integrator has
    std::string replicas = possible;  ///< that take part
    ChainParameters chains = {};
    InefficiencyParameters inefficiency = {};
    ReplicaSplit split = {};
    bool pooledTheta = false;
    template <class V>
    void visit(V&& v) {
        v("replicas", replicas, Letters{possible},
          "chains that take part: u (uniform), v (visibility), f (contribution)");
        v(chains);
        v(inefficiency);
        v("split", split, SplitForm{possible.find('f') != std::string::npos},
          "parts of the replicas u/v/f in the samples; auto: by the noise that each makes");
        v("theta", pooledTheta, Choices<bool>{{{"lane", false}, {"pooled", true}}},
          "adaptive kernel steered for each lane or for all together");
    }
};

}  // namespace metrolux::core
