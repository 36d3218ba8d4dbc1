#pragma once
/// Weights of the balance heuristic from the products of all densities along a path
/// (docs/explain/algorithm.md section 1): nothing recursive, nothing shared with transport/ but the models of
/// lights and materials.

#include "oracle/oracle_scene.h"
#include "transport/mis.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace metrolux::core::test {

/// A surface vertex between light and camera.
struct InnerVertex {
    SurfaceInteraction si;
    bool delta = false;  ///< the path follows a delta lobe here; no technique joins subpaths then
};

/// A full path, light to camera.
struct FullPath {
    const Light* light = nullptr;
    bool found = true;               ///< false: its light end could not be determined
    Vec3f toLight{0.0f};             ///< infinite lights: direction from x1
    SurfaceInteraction lightPoint;   ///< area lights: x0
    Vec3f lightPosition{0.0f};       ///< lights that have a place: of x0
    std::vector<InnerVertex> inner;  ///< x1 ... x_m
    Vec2f uLens{0.5f};               ///< names the point of the lens, which all techniques sample alike
    Vec2f raster{0.0f};              ///< where the path meets the film
};

/// A technique that can make a path: its name and the number s of light vertices (merge: without the one that
/// the eye subpath has too).
using TechniqueKey = std::pair<std::string, int>;

class BruteForce {
  public:
    BruteForce(const OracleScene& scene, const Strategies& counts)
        : oracle_(scene), scene_(*scene.scene), n_(counts) {}

    /// Weights of all techniques that can make the path.
    std::map<TechniqueKey, double> weights(const FullPath& path) const;

    /// The oracle takes directions from differences of float positions: short edges, grazing directions and
    /// densities that change quickly (refraction near total reflection) would test float rounding, not the
    /// recursion.
    bool wellConditioned(const FullPath& path) const;

  private:
    struct Geometry;
    EndpointDensities densities(const FullPath& path, const Geometry& g) const;
    /// Density of the direction to the eye (forward) or to the light, per solid angle. Delta lobes: their
    /// probability, in the measure of the eye-side direction.
    double scatterDensity(const InnerVertex& v, const Vec3f& wLight, const Vec3f& wEye, bool forward) const;

    const OracleScene& oracle_;
    const Scene& scene_;
    const Strategies& n_;
};

}  // namespace metrolux::core::test
