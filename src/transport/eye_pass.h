#pragma once
#include "base/rng.h"
#include "base/uninitialized.h"
#include "image/film.h"
#include "sampling/sample_stream.h"
#include "scene/scene.h"
#include "transport/walk.h"

#include <span>
#include <vector>

namespace metrolux::core {

/// The eye subpaths of an iteration: one for each pixel of `pixels`, with the vertices that can be connected
/// and merged.
class EyeVertices {
  public:
    std::span<const Vertex> all() const { return vertices_; }
    /// Vertices of the i-th eye subpath of the iteration (in the order of its pixels).
    std::span<const Vertex> subpath(size_t i) const {
        return {vertices_.data() + starts_[i], starts_[i + 1] - starts_[i]};
    }
    size_t subpathCount() const { return starts_.empty() ? 0 : starts_.size() - 1; }
    size_t memoryBytes() const {
        size_t sum = vertices_.capacity() * sizeof(Vertex) + starts_.capacity() * sizeof(size_t);
        for (const Kept& k : kept_)
            sum += k.vertices.capacity() * sizeof(Vertex) + k.places.capacity() * sizeof(uint32_t);
        return sum;
    }
    /// Subpaths whose vertices are in memory twice while they are gathered, with up to eight threads.
    static constexpr size_t kGroup = size_t{1} << 15;

    void clear() {
        vertices_.clear();
        starts_.assign(1, 0);
    }
    /// Adds a subpath.
    void append(std::span<const Vertex> subpath) {
        vertices_.insert(vertices_.end(), subpath.begin(), subpath.end());
        starts_.push_back(vertices_.size());
    }

  private:
    friend struct EyePass;
    friend class EyeWave;
    /// What a task of a pass has found, before it is put in order.
    struct Kept {
        UninitializedVector<Vertex> vertices;
        std::vector<uint32_t> places;  ///< index of each one's subpath in the task
    };
    static constexpr size_t kTask = 512;  ///< subpaths
    void begin(size_t subpaths, size_t tasks);
    /// Puts in order what so many tasks have kept, from this subpath on.
    void takeKept(size_t first, size_t tasks);

    UninitializedVector<Vertex> vertices_;
    std::vector<size_t> starts_;
    std::vector<Kept> kept_;  ///< of a group of tasks; keeps its memory from pass to pass
};

/// Traces the eye subpaths of an iteration; adds hit and nee to the film.
struct EyePass {
    const Scene& scene;
    const PathLimits& limits;
    const Strategies& strategies;
    uint64_t seed = 0;
    uint32_t pass = 0;
    bool nextEvent = true;  ///< next-event estimation
    bool keepVertices = true;
    bool hit = true;     ///< emitters hit at any depth; false: directly seen ones only
    bool direct = true;  ///< emitters that the camera sees directly
    int deepest = -1;    ///< subpaths end after this many edges; -1: at the scene's limit
    /// Photon mapping: vertices of narrow lobes (Bsdf::isNarrow) are not kept, and subpaths end where another
    /// smooth lobe scatters them.
    bool photonMapping = false;

    /// `pixels`: indices in the film's window. Deterministic for any number of threads.
    void run(std::span<const uint32_t> pixels, Film& film, EyeVertices& result) const;

    /// Traces one eye subpath (traceEyeSubpath) through `raster` and returns its hit and nee; appends its
    /// vertices to `kept`. Next-event estimation at depth d reads block d of `nee`; `film` counts non-finite
    /// contributions.
    Rgb trace(SampleStream& stream, SampleStream& nee, const Vec2f& raster, float weight, uint32_t pixel,
              Film& film, std::vector<Vertex>& kept) const;

    /// Coordinates of a vertex's block of `nee`: the choice of a light, a point on it (aligned to a pair).
    static constexpr int kLightCoordinate = 0, kLightPointCoordinate = 2;

    /// The key of the subpath of a pixel, and that of its next-event estimation.
    uint64_t key(const FilmWindow& window, uint32_t pixel) const;
    static uint64_t neeKey(uint64_t key) { return hashKey(key, 0x6e6565); }
    WalkRules rules() const { return {scene, limits, strategies, TransportMode::Radiance}; }

    /// Next-event estimation at one vertex of a subpath.
    Rgb estimateDirect(const Vertex& v, SampleStream& nee, Film& film) const;
};

}  // namespace metrolux::core
