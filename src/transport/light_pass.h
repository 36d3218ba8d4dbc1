#pragma once
#include "image/film.h"
#include "sampling/sample_stream.h"
#include "transport/eye_pass.h"
#include "transport/pixel_importance.h"
#include "transport/vertex_grid.h"

#include <atomic>
#include <span>

namespace metrolux {

/// How often a light pass has done what, for measurements.
struct LightWork {
    std::atomic<uint64_t> splats{0}, connections{0};  ///< tried
    std::atomic<uint64_t> merges{0};                  ///< vertices within the radius
};

/// evaluate(u) -> splats of ALGORITHM.md section 2: everything that one light subpath contributes in an
/// iteration. A pure function of the stream, given the iteration's eye vertices.
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

    /// Appends to `splats` (cleared first). Scales: a pixel splat is the estimate of its pixel from one light
    /// subpath; divide by the number of light subpaths to average. `counted`: where the subpath's vertices
    /// are counted, if given; `trail`: receives their positions (cleared first).
    void evaluate(SampleStream& stream, SplatList& splats, PhotonDensity* counted = nullptr,
                  std::vector<Vec3f>* trail = nullptr) const;

    /// F(u) of what evaluate() found.
    double size(const SplatList& splats) const {
        return importance ? importance->size(splats) : splats.size();
    }

    /// evaluate() with the eye subpath given: `partner` has the vertices to connect with, and
    /// `connectionScale` is one over the probability of that choice. Appends to `splats` and `trail`.
    void trace(SampleStream& stream, std::span<const Vertex> partner, float connectionScale,
               SplatList& splats, PhotonDensity* counted = nullptr,
               std::vector<Vec3f>* trail = nullptr) const;
};

/// Order of the window's pixels along a Hilbert curve: a small step in the curve's parameter is a near pixel.
std::vector<uint32_t> hilbertOrder(int width, int height);

}  // namespace metrolux
