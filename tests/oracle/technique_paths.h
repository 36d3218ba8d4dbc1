#pragma once
/// Random paths of every technique, each with the weight that transport/ gives it.

#include "base/rng.h"
#include "oracle/brute_force.h"
#include "transport/subpath.h"

#include <functional>
#include <set>

namespace metrolux::core::test {

/// Keeps the vertices of a subpath, and where it leaves the scene.
class Collector final : public SubpathVisitor {
  public:
    std::vector<Vertex> vertices;
    std::vector<bool> deltas;  ///< of each vertex that the walk has gone on from: by a delta lobe
    bool ended = false;
    Vec3f escapeFrom{0.0f};
    WalkEdge escape;
    int escapeDepth = 0;

    bool surface(const Vertex& v) override {
        vertices.push_back(v);
        return true;
    }
    bool scattered(bool delta) override {
        deltas.push_back(delta);
        return true;
    }
    void escaped(const Vec3f& from, const WalkEdge& edge, int depth) override {
        ended = true;
        escapeFrom = from;
        escape = edge;
        escapeDepth = depth;
    }
};

class TechniquePaths {
  public:
    /// Receives a path, the technique that has made it, and its weight.
    using Check = std::function<void(const TechniqueKey&, const FullPath&, double weight)>;
    /// Whether more paths of a technique of this name are wanted.
    using Wanted = std::function<bool(const std::string& name)>;

    TechniquePaths(const OracleScene& scene, const Strategies& counts, Check check, Wanted wanted)
        : oracle_(scene),
          scene_(*scene.scene),
          n_(counts),
          check_(std::move(check)),
          wanted_(std::move(wanted)) {}

    /// Makes a pair of subpaths and all paths that come from it.
    void run(uint64_t index);

    /// Eye vertices so far whose share of merging is well below one.
    int reducedShares() const { return reducedShares_; }

  private:
    void hits();
    void nextEvents();
    void splats();
    void connections();
    void merges();
    /// Vertex a of the light subpath, seen as the end of the eye subpath's edge from its vertex b - 1 (from
    /// the camera if b = 0). The two vertices of a merge are moved onto each other, so that the path is one.
    std::optional<Vertex> joinedVertex(size_t a, size_t b);
    Passage passageFrom(const Vertex& v, const Vec3f& p, const Vec3f& ng) const;

    /// Sets the light end of a path whose x1 has been reached from `light` as `first` has.
    void setLight(FullPath& path, const Light* light, const Vertex& first) const;
    /// Appends the first vertices of the light subpath; the path leaves the last of them by a smooth lobe.
    void appendLight(FullPath& path, size_t count) const;
    /// Appends the first vertices of the eye subpath in reverse. `smoothEnd`: the path leaves the last of
    /// them by a smooth lobe, and not as the subpath has gone on.
    void appendEye(FullPath& path, size_t count, bool smoothEnd) const;

    const OracleScene& oracle_;
    const Scene& scene_;
    const Strategies& n_;
    Check check_;
    Wanted wanted_;
    int reducedShares_ = 0;

    Collector eye_, light_;
    const Light* source_ = nullptr;  ///< of the light subpath
    Vec2f uLens_{0.0f};              ///< of the eye subpath
    Vec2f raster_{0.0f};             ///< the same, and of the last vertex joined with the camera itself
    Vec2f joinedRaster_{0.0f};
    CounterRng rng_{0}, choices_{0};
};

}  // namespace metrolux::core::test
