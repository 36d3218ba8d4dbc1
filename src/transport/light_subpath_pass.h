#pragma once
#include "image/splat.h"
#include "sampling/sample_stream.h"
#include "spatial/vertex_grid.h"
#include "transport/eye_pass.h"
#include "transport/eye_tail.h"

#include <atomic>
#include <span>
#include <vector>

namespace metrolux::core {

/// How often a pass over light subpaths has done what, for measurements.
struct TechniqueWork {
    std::atomic<uint64_t> splats{0}, connections{0};  ///< tried
    std::atomic<uint64_t> merges{0};                  ///< vertices within the radius
};

/// A light subpath to evaluate, and where what it finds goes.
struct LightSubpathJob {
    SampleStream* stream = nullptr;
    SplatList* splats = nullptr;          ///< cleared first
    PhotonDensity* counted = nullptr;     ///< where the subpath's vertices are counted, if given
    std::vector<Vec3f>* trail = nullptr;  ///< receives their positions (cleared first), if given
};

/// evaluate(u) -> splats of docs/explain/algorithm.md, section 2: everything that one light subpath
/// contributes in an iteration, by those of splat, connect and merge that the strategies have. A pure
/// function of the stream, given the iteration's eye vertices. This is the definition, one subpath at a time;
/// wavefront/light_subpath_wavefront.h gives the same bits faster.
struct LightSubpathPass {
    const Scene& scene;
    const PathLimits& limits;
    const Strategies& strategies;
    const EyeVertices& eyes;
    const VertexGrid& grid;                   ///< over those on surfaces; empty: nothing to merge with
    NonFiniteCounts& nonFinite;               ///< counts what is left out
    TechniqueWork* work = nullptr;            ///< counts, if given; in wavefronts only
    const VertexGrid* mediumGrid = nullptr;   ///< over the eye vertices in media, if any
    std::span<const float> shareInside = {};  ///< of each eye vertex, where there is mediumGrid
    const EyeTail* tail = nullptr;  ///< for SplatList::surprise, if given; needs Strategies::eyeFactors

    /// Scales: a pixel splat is the estimate of its pixel from one light subpath; divide by the number of
    /// light subpaths to average.
    void evaluate(const LightSubpathJob& job) const;

    /// The vertices of an eye subpath to connect with, and one over the probability of that choice.
    struct Partner {
        std::span<const Vertex> vertices;
        float scale = 1;
    };
    /// The same with the eye subpath given.
    void evaluate(const LightSubpathJob& job, const Partner& partner) const;

    // What evaluate() is made of, for those who trace many subpaths together.

    /// One eye subpath of all, for the share of the light subpaths that is connected: its pixel's share
    /// stands for all.
    Partner choosePartner(SampleStream& stream) const;
    WalkRules rules() const { return {scene, limits, strategies, TransportMode::Importance}; }
    /// The eye vertices that a vertex is merged with; null if there are none.
    const VertexGrid* gridFor(const Vertex& v) const {
        const VertexGrid* g = v.inMedium ? mediumGrid : &grid;
        const bool merges = strategies.merge > 0 && (!v.inMedium || strategies.mergeInMedia > 0);
        return g && merges && !g->empty() ? g : nullptr;
    }
    /// One over the measure of the points within its radius: of a disk on a surface, of a ball in a medium.
    static double kernelOf(const VertexGrid& g, bool inMedium) {
        const double r = g.radius();
        return 1.0 / (double(kPi) * r * r * (inMedium ? 4.0 / 3.0 * r : 1.0));
    }
    /// Whether a path with that many more edges is not too long: the way to the camera has one at least.
    bool extensible(const Vertex& v, int edges = 1) const {
        return limits.maxDepth < 0 || v.depth + edges <= limits.maxDepth;
    }
    /// Merges with an eye vertex unless a wall stands between the two; `kernel`: kernelOf() their grid.
    void merge(const Vertex& light, uint32_t eye, double kernel, SplatList& splats) const;
    /// Adds a finite contribution to a pixel.
    void addPixel(uint32_t pixel, const LightFinding& found, Technique technique, SplatList& splats) const {
        if (nonFinite.reject(found.value, technique) || isBlack(found.value)) return;
        splats.add(pixel, found.value, found.eye.share);
        if (tail) splats.surprise += surprise(strategies.regionOf(pixel), found);
    }
    /// Adds a finite contribution to the film.
    void addToFilm(const Vec2f& raster, const LightFinding& found, SplatList& splats) const {
        if (nonFinite.reject(found.value, Technique::Splat) || isBlack(found.value)) return;
        splats.add(raster, found.value, found.eye.share);
        if (tail) splats.surprise += tail->filmShare * surprise(strategies.regionOf(raster), found);
    }

  private:
    Surprise surprise(uint16_t region, const LightFinding& found) const {
        return tail->surprise(region, luminance(found.value), found.eye,
                              std::max(strategies.hit, strategies.nee));
    }
};

}  // namespace metrolux::core
