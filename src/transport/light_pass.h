#pragma once
#include "geometry/ray_batch.h"
#include "image/film.h"
#include "sampling/sample_stream.h"
#include "transport/eye_pass.h"
#include "transport/pixel_importance.h"
#include "transport/vertex_grid.h"

#include <atomic>
#include <span>

namespace metrolux::core {

/// How often a light pass has done what, for measurements.
struct LightWork {
    std::atomic<uint64_t> splats{0}, connections{0};  ///< tried
    std::atomic<uint64_t> merges{0};                  ///< vertices within the radius
};

/// A light subpath to evaluate, and where what it finds goes.
struct LightJob {
    SampleStream* stream = nullptr;
    SplatList* splats = nullptr;          ///< cleared first
    PhotonDensity* counted = nullptr;     ///< where the subpath's vertices are counted, if given
    std::vector<Vec3f>* trail = nullptr;  ///< receives their positions (cleared first), if given
};

/// evaluate(u) -> splats of docs/explain/algorithm.md section 2: everything that one light subpath
/// contributes in an iteration. A pure function of the stream, given the iteration's eye vertices.
struct LightPass {
    const Scene& scene;
    const PathLimits& limits;
    const Strategies& strategies;
    const EyeVertices& eyes;
    const VertexGrid& grid;
    Film& film;           ///< counts non-finite contributions, nothing else
    bool connect = true;  ///< connect with the vertices of one eye subpath
    bool merge = true;
    bool splat = true;          ///< connect with the camera
    bool weighted = true;       ///< false: splats (light tracing) or merges (photon mapping) have weight one
    LightWork* work = nullptr;  ///< counts, if given
    const PixelImportance* importance = nullptr;  ///< of size(); null: all pixels count alike

    /// Coordinates of block 0 that the light's emission does not use.
    static constexpr int kEyeSubpathCoordinate = 5;
    static constexpr int kLensCoordinate = 6;
    /// The point of the lens for connections to the camera.
    static Vec2f lensCoordinates(SampleStream& stream);

    /// Evaluates several subpaths side by side. Scales: a pixel splat is the estimate of its pixel from one
    /// light subpath; divide by the number of light subpaths to average. Coherence::Alone: what a subpath
    /// contributes is the same to the bit whichever others there are.
    void evaluate(std::span<const LightJob> jobs, Coherence coherence) const;

    /// F(u) of what evaluate() found.
    double size(const SplatList& splats) const {
        return importance ? importance->size(splats) : splats.size();
    }

    /// Evaluates one, with the eye subpath given: `partner` has the vertices to connect with, and
    /// `connectionScale` is one over the probability of that choice.
    void trace(const LightJob& job, std::span<const Vertex> partner, float connectionScale) const;

    WalkRules rules() const { return {scene, limits, strategies, TransportMode::Importance}; }
};

/// Order of the window's pixels along a Hilbert curve: a small step in the curve's parameter is a near pixel.
std::vector<uint32_t> hilbertOrder(int width, int height);

}  // namespace metrolux::core
