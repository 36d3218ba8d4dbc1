#pragma once
#include "base/rng.h"
#include "base/uninitialized.h"
#include "image/film.h"
#include "sampling/sample_stream.h"
#include "scene/scene.h"
#include "transport/connect.h"
#include "transport/technique.h"
#include "transport/walk.h"

#include <span>
#include <vector>

namespace metrolux::core {

/// The eye subpaths of an iteration, in the order of its pixels, with the vertices that can be connected and
/// merged.
struct EyeVertices {
    UninitializedVector<Vertex> vertices;
    std::vector<size_t> starts;  ///< of each subpath in `vertices`, and the end of the last

    std::span<const Vertex> all() const { return vertices; }
    /// Vertices of the i-th eye subpath of the iteration.
    std::span<const Vertex> subpath(size_t i) const {
        return {vertices.data() + starts[i], starts[i + 1] - starts[i]};
    }
    size_t subpathCount() const { return starts.empty() ? 0 : starts.size() - 1; }
    size_t memoryBytes() const {
        return vertices.capacity() * sizeof(Vertex) + starts.capacity() * sizeof(size_t);
    }
    void clear() {
        vertices.clear();
        starts.assign(1, 0);
    }
    /// Adds a subpath.
    void append(std::span<const Vertex> subpath) {
        vertices.insert(vertices.end(), subpath.begin(), subpath.end());
        starts.push_back(vertices.size());
    }
};

/// The sums of what one eye subpath has found.
struct EyeSum {
    Rgb value{0.0f};
    EyeEstimate alone{};
    void add(const EyeFinding& found) {
        value += found.value;
        addTo(alone, found.smooth, found.alone);
    }
};

/// Traces the eye subpaths of an iteration: adds hit and nee to the film and keeps the vertices that light
/// subpaths are joined with, as far as the strategies have them. This is the definition, one subpath after
/// the other; wavefront/eye_wavefront.h gives the same bits faster.
struct EyePass {
    const Scene& scene;
    const PathLimits& limits;
    const Strategies& strategies;
    NonFiniteCounts& nonFinite;  ///< counts what trace() and its parts leave out
    uint64_t seed = 0;
    uint32_t pass = 0;
    EyeFactors* factors = nullptr;  ///< learns what each pixel's subpath has found, if given

    /// `pixels`: indices in the film's window.
    void run(std::span<const uint32_t> pixels, Film& film, EyeVertices& result) const;

    /// Traces one eye subpath (traceEyeSubpath) through `raster` and returns its hit and nee; appends its
    /// vertices to `kept`. Next-event estimation at depth d reads block d of `nee`; without a stream it is
    /// left to the caller.
    EyeSum trace(SampleStream& stream, SampleStream* nee, const Vec2f& raster, float weight, uint32_t pixel,
                 std::vector<Vertex>& kept) const;
    /// Adds what the subpath of a pixel has found to the film.
    void add(uint32_t pixel, const EyeSum& sum, Film& film) const;

    // What trace() is made of, for those who trace many subpaths together.

    /// The key of the subpath of a pixel, and that of its next-event estimation.
    uint64_t key(const FilmWindow& window, uint32_t pixel) const;
    static uint64_t neeKey(uint64_t key) { return hashKey(key, 0x6e6565); }
    WalkRules rules() const { return {scene, limits, strategies, TransportMode::Radiance}; }

    /// What hitting an emitter by chance adds: at a vertex, and beyond the scene (SubpathVisitor::escaped).
    EyeFinding hit(const Vertex& v) const;
    EyeFinding escaped(const Vec3f& from, const WalkEdge& edge, int depth) const;
    /// Next-event estimation at one vertex of a subpath.
    EyeFinding estimateDirect(const Vertex& v, SampleStream& nee) const;

    /// Whether other techniques than hit work at a vertex. Photon mapping leaves narrow lobes to the walk.
    bool joins(const Vertex& v) const {
        if (!v.hasSmoothLobe()) return false;
        if (strategies.mergeAt == Strategies::MergeAt::EveryVertex) return true;
        return v.inMedium ? strategies.mergeInMedia > 0 : !v.isNarrow();
    }
    /// Whether a path with one more edge is not too long.
    bool extensible(const Vertex& v) const { return limits.maxDepth < 0 || v.depth < limits.maxDepth; }
    /// Whether the direction is followed that a vertex scattered into, which joins() or not.
    bool follows(bool joined, bool delta) const {
        return delta || !joined || strategies.mergeAt == Strategies::MergeAt::EveryVertex;
    }

    /// The finding, or nothing in place of one that is not finite.
    EyeFinding finite(const EyeFinding& found, Technique technique) const {
        return nonFinite.reject(found.value, technique) ? EyeFinding{} : found;
    }

  private:
    bool countsHit(int depth) const {
        return strategies.hit > 0 && depth >= limits.minDepth && !(depth == 1 && limits.hideEmitters);
    }
};

}  // namespace metrolux::core
