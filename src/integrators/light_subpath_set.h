#pragma once
/// Two ways to make the set L of light subpaths that pssmlt_merge merges with (supplement, 4.1.1).

#include "integrators/iteration.h"
#include "integrators/photon_map.h"
#include "markov/normalization.h"
#include "markov/replica_mixture.h"
#include "markov/replica_pool.h"

#include <nlohmann/json_fwd.hpp>

namespace metrolux::core {

/// What light subpaths are traced with in an iteration.
struct LightSubpathTracing {
    const Scene& scene;
    const PathLimits& limits;
    const Strategies& strategies;
    PhotonDensity* photons = nullptr;  ///< counts the vertices of uniform light subpaths, if given

    /// Appends the vertices of the light subpath of a stream.
    void trace(SampleStream& stream, std::vector<Vertex>& vertices) const {
        traceLightVertices(scene, stream, limits, strategies, vertices);
    }
    void count(const std::vector<Vertex>& vertices) const {
        if (!photons) return;
        for (const Vertex& v : vertices) photons->count(v.si.p);
    }
};

/// Method B: half of the light subpaths are uniform, half come from visibility-driven chains with replica
/// exchange [HJ11]. V(u) = 1 if a vertex lies within the merging radius of an eye vertex of the iteration.
/// Invisible uniform ones are part of L: other eye subpaths than those may meet them.
///
/// It shares chains, queue and pool with ReplicaLanes, but has a driver of its own, because what ReplicaLanes
/// adds has no place here. L is a set that is complete before anything is merged with it: all uniform samples
/// of the iteration are traced first and all visible ones are the pool, while ReplicaLanes bounds its pool
/// and takes the rest between the steps of its chains. An iteration without visible ones needs no states of
/// earlier iterations: its L is the uniform half, and the chains wait, with weight 0. And there is no
/// contribution replica, since F is the business of the eye subpaths that merge with L.
class VisibilityDrivenSet {
  public:
    VisibilityDrivenSet(const IntegratorOptions& options, size_t samples);

    /// Decides about the iteration to come; the result is known before anything is traced.
    void begin(size_t samples, double radius);
    /// Samples of L times their density boost q: what merging counts for.
    double effectiveSamples() const { return mix_.samples() * mix_.boost(); }
    /// Vertices of L, whose throughputs carry the weights. `eyeGrid`: over the iteration's eye vertices.
    std::vector<Vertex> make(const LightSubpathTracing& tracing, const VertexGrid& eyeGrid);

    /// Between two iterations: states begin anew in each.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(rng_, normalization_);
        serializeElements(archive, lanes_, "lanes");
    }

    nlohmann::json statistics() const;

  private:
    struct Value {
        std::vector<Vertex> vertices;
        double size = 0;  ///< V(u)
        bool visible() const { return size > 0; }
    };
    using State = MarkovState<Value>;
    struct Lane {
        Lane(uint64_t key, MutationKernel::Kind kind) : rng(key), chain(VisibilityTarget{}, kind) {}
        CounterRng rng;
        MarkovChain<Value, VisibilityTarget> chain;
        State proposal;
        UniformQueue<Value> uniform;
        std::vector<Vertex> result;
        Normalization::Samples samples;

        /// Adds what a state contributes with the weight that it has earned.
        void pay(State& state);
        template <class Archive>
        void serialize(Archive& archive) {
            archive(rng, chain);
        }
    };
    size_t stepsOf(size_t lane) const;
    void takeUniform(Lane& lane, size_t steps, const LightSubpathTracing& tracing, const VertexGrid& eyeGrid);
    void startChains();
    void runLane(Lane& lane, size_t steps, const LightSubpathTracing& tracing, const VertexGrid& eyeGrid);
    static void evaluate(const LightSubpathTracing& tracing, const VertexGrid& eyeGrid, SampleStream& u,
                         Value& value);

    CounterRng rng_;
    double inefficiency_;
    std::vector<Lane> lanes_;
    Normalization normalization_;
    ReplicaMixture mix_;
    double squaredRadius_ = 0;
    bool chainsRun_ = false;
};

/// Method A, experimental: light subpaths of the states that pssmlt's chains had in the last iteration, and
/// as many uniform ones. The density of the states is not known. It is estimated from the numbers of vertices
/// of both kinds in the cells of a grid, rho = chain-made / uniform, and a vertex in such a cell weighs 1 /
/// (n_U + n_A rho). That rho is a constant in a cell, the same for all directions and predecessors, and known
/// with noise makes it biased (docs/lab/integrators.md).
class ChainStateSet {
  public:
    /// `cell`: edge of the cells, in scene units.
    ChainStateSet(const IntegratorOptions& options, double cell, size_t lanes);

    /// The state of a lane after a step; the lanes may call at once.
    template <class State>
    void observe(size_t lane, const State& state, bool moved) {
        std::vector<Visited>& visited = visited_[lane];
        if (moved || visited.empty()) visited.push_back({state.u, 0});
        ++visited.back().steps;
    }
    /// Samples of L with `uniform` uniform ones: as many as there are, no boost.
    double effectiveSamples(size_t uniform) const { return double(uniform) + double(steps()); }
    /// Vertices of L, whose throughputs carry the weights; the observed states are forgotten. `pass` and
    /// `first` name the uniform samples.
    std::vector<Vertex> make(const LightSubpathTracing& tracing, size_t uniform, uint32_t pass, size_t first);

    /// Between two iterations.
    template <class Archive>
    void serialize(Archive& archive) {
        serializeElements(archive, visited_, "lanes");
        archive(chainMade_, uniform_);
    }

  private:
    struct Visited {
        PrimarySample u;
        uint32_t steps;
        template <class Archive>
        void serialize(Archive& archive) {
            serializeSample(archive, u);
            archive(steps);
        }
    };
    size_t steps() const;
    std::vector<std::vector<Vertex>> traceStates(const LightSubpathTracing& tracing);
    std::vector<std::vector<Vertex>> traceUniform(const LightSubpathTracing& tracing, size_t count,
                                                  uint32_t pass, size_t first);

    uint64_t seed_;
    std::vector<std::vector<Visited>> visited_;  ///< of each lane
    PhotonDensity chainMade_, uniform_;
};

}  // namespace metrolux::core
