#pragma once
#include "transport/connect.h"
#include "transport/eye_pass.h"
#include "transport/walk.h"

namespace metrolux::core {

/// What an EyePass adds up at the vertices of one eye subpath.
class EyeGathering {
  public:
    EyeGathering(const EyePass& pass, Film& film) : pass_(pass), film_(film) {}

    /// Hit by chance.
    void hit(const Vertex& v, Rgb& sum) const {
        if (v.si.shape->emitter && countsHit(v.depth)) add(hitLight(pass_.scene, pass_.strategies, v), sum);
    }
    void escaped(const Vec3f& from, const WalkEdge& edge, int depth, Rgb& sum) const {
        if (countsHit(depth))
            add(hitEnvironment(pass_.scene, pass_.strategies, from, edge.ray.direction, edge.throughput,
                               edge.mis, depth),
                sum);
    }
    bool ends(const Vertex& v) const { return pass_.deepest >= 0 && v.depth >= pass_.deepest; }
    /// Whether other techniques than hit work at the vertex.
    bool gathers(const Vertex& v) const {
        return v.bsdf().hasSmoothLobe() && !(pass_.photonMapping && v.bsdf().isNarrow(v.si));
    }
    bool extensible(const Vertex& v) const {
        return pass_.limits.maxDepth < 0 || v.depth < pass_.limits.maxDepth;
    }
    /// Whether the direction is followed that a vertex scattered into.
    bool follows(bool gathered, bool delta) const { return delta || !pass_.photonMapping || !gathered; }

  private:
    bool countsHit(int depth) const {
        if (depth == 1) return pass_.direct && !pass_.limits.hideEmitters;
        return pass_.hit;
    }
    void add(const Rgb& value, Rgb& sum) const {
        if (!film_.rejectNonFinite(value, Technique::Hit)) sum += value;
    }

    const EyePass& pass_;
    Film& film_;
};

/// The eye subpaths of several pixels, side by side: their rays are traced together, their random numbers are
/// made together, and memory that one waits for is asked for while others are at work. Each subpath is the
/// one that EyePass::trace makes alone, and its sum is the same to the bit.
class EyeWave {
  public:
    EyeWave(const EyePass& pass, Film& film) : pass_(pass), film_(film), gathering_(pass, film) {}

    /// Vertices in the order of their depth, with the index in `pixels` of each.
    using Kept = EyeVertices::Kept;
    void run(std::span<const uint32_t> pixels, Kept& kept);

  private:
    struct Lane {
        Vertex v;
        WalkEdge edge;
        Rgb sum{0.0f};
        bool certain = true;   ///< see arrive()
        bool gathers = false;  ///< at the last vertex
    };
    /// Next-event estimation of a lane that waits for its shadow ray.
    struct Waiting {
        uint32_t lane;
        Rgb value;
    };

    void start(std::span<const uint32_t> pixels);
    void arrive(std::span<const uint32_t> pixels, int depth);
    void makeNumbers(int depth);
    void gather(Kept& kept);
    void estimateDirect();
    void scatter(int depth);

    const EyePass& pass_;
    Film& film_;
    EyeGathering gathering_;
    std::vector<Lane> lanes_;
    std::vector<uint64_t> eyeKeys_, neeKeys_;  ///< of each lane
    std::vector<uint32_t> active_;             ///< lanes on their way
    RayBatch rays_;                            ///< of active_
    OcclusionBatch shadows_;
    std::vector<Waiting> waiting_;  ///< of shadows_

    /// Random numbers of active_ at the present depth.
    struct Numbers {
        std::vector<uint64_t> eyeKeys, neeKeys;
        std::vector<float> lobe, scatterX, scatterY, roulette, light, lightX, lightY;
    } numbers_;
};

}  // namespace metrolux::core
