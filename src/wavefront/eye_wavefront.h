#pragma once
#include "geometry/ray_batch.h"
#include "transport/eye_pass.h"

#include <span>
#include <vector>

namespace metrolux::core {

/// Eye subpaths of a task, side by side: their rays are traced together, their random numbers are made
/// together, and memory that one waits for is prefetched while others are at work. Each subpath is the one
/// that EyePass::trace makes alone, and its sum is the same to the bit.
class EyeWavefront {
  public:
    EyeWavefront(const EyePass& pass, Film& film) : pass_(pass), film_(film) {}

    /// Vertices in the order of their depth, and for each the index of its subpath in `pixels`.
    struct Kept {
        UninitializedVector<Vertex> vertices;
        std::vector<uint32_t> places;
    };
    void run(std::span<const uint32_t> pixels, Kept& kept);

  private:
    struct Subpath {
        Vertex v;
        WalkEdge edge;
        EyeSum sum;
        bool certain = true;  ///< see arrive()
        bool joins = false;   ///< at the last vertex
    };
    /// Next-event estimation of a subpath that waits for its shadow ray.
    struct Waiting {
        uint32_t subpath;
        PendingConnection connection;
    };

    void start(std::span<const uint32_t> pixels);
    void arrive(std::span<const uint32_t> pixels, int depth);
    void makeNumbers(int depth);
    void gather(Kept& kept);
    void estimateDirect();
    void scatter(int depth);

    const EyePass& pass_;
    Film& film_;
    std::vector<Subpath> subpaths_;
    std::vector<uint64_t> eyeKeys_, neeKeys_;  ///< of each subpath
    std::vector<uint32_t> active_;             ///< subpaths on their way
    RayBatch rays_;                            ///< of active_
    OcclusionBatch shadows_;
    std::vector<Waiting> waiting_;  ///< of shadows_

    /// Random numbers of active_ at the present depth.
    struct Numbers {
        std::vector<uint64_t> eyeKeys, neeKeys;
        std::vector<float> lobe, scatterX, scatterY, roulette, light, lightX, lightY;
    } numbers_;
};

/// Runs an EyePass in wavefronts, on all threads. Keeps its memory from pass to pass.
class EyeWavefronts {
  public:
    /// As EyePass::run(), to the bit, for any number of threads.
    void run(const EyePass& pass, std::span<const uint32_t> pixels, Film& film, EyeVertices& result);

    /// Subpaths whose vertices are in memory twice while they are gathered, with up to eight threads.
    static constexpr size_t kGroup = size_t{1} << 15;
    size_t memoryBytes() const;

  private:
    static constexpr size_t kTask = 512;  ///< subpaths
    /// Puts in order what so many tasks have kept, from this subpath on.
    void takeKept(size_t first, size_t tasks, EyeVertices& result);

    std::vector<EyeWavefront::Kept> kept_;  ///< of a group of tasks
};

}  // namespace metrolux::core
