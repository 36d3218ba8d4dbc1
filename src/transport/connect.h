#pragma once
/// The techniques that join subpaths deterministically (docs/explain/algorithm.md section 1), each with its
/// weight. All return the weighted contribution of one sample; visibility is tested.

#include "scene/scene.h"
#include "transport/vertex.h"

namespace metrolux::core {

struct WalkEdge;

/// What an eye subpath finds by itself.
struct EyeFinding {
    Rgb value{0.0f};
    float alone = 0;  ///< luminance of what it would be if hit and nee were all techniques
    int smooth = 0;   ///< PathClass::smooth of its path
};

/// Eye subpath ends on the area light at `v` (s = 0).
EyeFinding hitLight(const Scene& scene, const Strategies& strategies, const Vertex& v);

/// Eye subpath leaves the scene into the environment (s = 0), see SubpathVisitor::escaped.
EyeFinding hitEnvironment(const Scene& scene, const Strategies& strategies, const Vec3f& from,
                          const WalkEdge& edge, int depth);

/// A connection whose visibility is still to be asked for.
struct PendingConnection {
    Rgb value{0.0f};  ///< if nothing is in the way
    Ray shadow;       ///< of visibility()
    float alone = 0;  ///< of next-event estimation: EyeFinding::alone if nothing is in the way
    EyeRival eye;     ///< of a light vertex: LightWeight::eye
};

/// Share of the light that passes an edge whose shadow ray is blocked by a surface or not.
inline Rgb visibility(bool blocked) { return Rgb(blocked ? 0.0f : 1.0f); }
inline Rgb visibility(const Scene& scene, const Ray& shadow) { return visibility(!scene.isFree(shadow)); }
/// What is left of a value: nothing, however large it is, where nothing passes.
inline Rgb throughEdge(const Rgb& value, const Rgb& visibility) {
    return isBlack(visibility) ? Rgb(0.0f) : value * visibility;
}

/// Next-event estimation at `eye` through this edge.
EyeFinding findLight(const Vertex& eye, const PendingConnection& pending, const Rgb& visibility);

/// Eye vertex to a fresh light point (s = 1). False when its value is zero whatever is in the way.
bool prepareLight(const Scene& scene, const Strategies& strategies, const Vertex& eye, float uLight,
                  const Vec2f& u, PendingConnection& pending);
/// The same with its visibility.
EyeFinding connectToLight(const Scene& scene, const Strategies& strategies, const Vertex& eye, float uLight,
                          const Vec2f& u);

/// What a light subpath finds.
struct LightFinding {
    Rgb value{0.0f};
    EyeRival eye;  ///< LightWeight::eye
};

/// Light vertex to the camera (t = 1). The value is per pixel area at `raster`. False when it is zero
/// whatever is in the way.
bool prepareCamera(const Scene& scene, const Strategies& strategies, const Vertex& light, const Vec2f& uLens,
                   Vec2f& raster, PendingConnection& pending);
/// The same with its visibility.
LightFinding connectToCamera(const Scene& scene, const Strategies& strategies, const Vertex& light,
                             const Vec2f& uLens, Vec2f& raster);

/// Light vertex to eye vertex (s, t >= 2). False when the value is zero whatever is in the way.
bool prepareVertices(const Scene& scene, const Strategies& strategies, const Vertex& light, const Vertex& eye,
                     PendingConnection& pending);
/// The same with its visibility.
LightFinding connectVertices(const Scene& scene, const Strategies& strategies, const Vertex& light,
                             const Vertex& eye);

/// Light vertex merged with an eye vertex at distance <= radius; the value is multiplied by 1 / (pi r^2).
/// Photons from the other side of a sheet are refused by their normals; whether a wall stands between the two
/// is for the caller to ask (transport/merge_walls.h).
LightFinding mergeVertices(const Strategies& strategies, const Vertex& light, const Vertex& eye,
                           double inverseDiskArea);

/// The same in a medium (P-P3D of [Kri14]): the value is multiplied by 1 / (4/3 pi r^3). Only vertices in the
/// same medium are merged; whether a surface stands between the two is for the caller to ask.
LightFinding mergeInMedium(const Strategies& strategies, const Vertex& light, const Vertex& eye,
                           double inverseVolume);

}  // namespace metrolux::core
