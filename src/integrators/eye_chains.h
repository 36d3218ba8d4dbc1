#pragma once
/// Eye subpaths from Markov chains (supplement of [Sik16], section 4.2): the eye pass of split_mcmc.

#include "integrators/light_subpath_chains.h"

namespace metrolux::core {

/// What the primary sample of an eye subpath evaluates to.
struct EyeSubpath {
    uint32_t pixel = 0;
    Rgb hit{0.0f};  ///< what emitters that it hits add to the pixel
    std::vector<Vertex> vertices;
    double size = 0;  ///< 1 if a vertex is near a light vertex, else 0
    bool visible() const { return size > 0; }
};

/// Eye subpaths of an iteration, from the uniform and the visibility replica. Unlike light subpaths,
/// invisible ones contribute too (hit, nee, connections), so that uniform samples are used whether visible or
/// not.
class EyeChains {
  public:
    EyeChains(const ReplicaSettings& settings, const FilmWindow& window);

    /// Decides about the samples of the iteration to come, before its weights are known.
    void begin(size_t samples, double radius);
    double samples() const { return mix_.samples(); }
    /// Their density over that of evenly distributed ones, where visible.
    double boost() const { return mix_.boost(); }

    /// Traces them, adds hit and nee to the film, and gives the vertices in the order of a Hilbert curve over
    /// the pixels, their throughputs multiplied by N W(u). `lightVertices` define visibility. `first` and
    /// `count` of the light iteration name this one.
    void run(const EyePass& pass, const VertexGrid& lightVertices, Film& film,
             const LightSubpathIteration& iteration, EyeVertices& result);

    /// Between two iterations.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(lanes_);
    }

    nlohmann::json statistics() const;

  private:
    /// Subpaths of a lane that have got their weight.
    struct Weighted {
        std::vector<uint32_t> pixels;
        std::vector<size_t> ends;  ///< in `vertices`
        std::vector<Vertex> vertices;
        uint32_t count = 0;  ///< with those that have no vertices
    };
    struct Model;
    void gather(EyeVertices& result) const;

    std::vector<uint32_t> order_, rank_;  ///< pixels along the curve, and the inverse
    ReplicaLanes<EyeSubpath> lanes_;
    std::vector<Weighted> weighted_;
    ReplicaMixture mix_;
    double squaredRadius_ = 0;
};

}  // namespace metrolux::core
