#include "integrators/photon_map.h"

#include "transport/connect.h"
#include "transport/merge_walls.h"

namespace metrolux::core {

void PhotonMap::build(std::vector<Vertex> vertices, float radius) {
    vertices_ = std::move(vertices);
    grid_.clear();
    grid_.build(positionsOf(vertices_), radius);
    inverseDiskArea_ = 1.0 / (double(kPi) * radius * radius);
}

Rgb PhotonMap::merge(const Scene& scene, const Strategies& strategies, const Vertex& eye,
                     int maxDepth) const {
    Rgb sum(0.0f);
    grid_.query(eye.si.p, [&](uint32_t index) {
        const Vertex& light = vertices_[index];
        if (maxDepth >= 0 && light.depth + eye.depth > maxDepth) return;
        const Rgb value = mergeVertices(strategies, light, eye, inverseDiskArea_).value;
        if (!isBlack(value) && !isWallBetween(scene, light, eye, grid_.radius())) sum += value;
    });
    return sum;
}

namespace {

class KeepVertices final : public SubpathVisitor {
  public:
    KeepVertices(int maxDepth, std::vector<Vertex>& kept) : maxDepth_(maxDepth), kept_(kept) {}
    bool surface(const Vertex& v) override {
        if (v.hasSmoothLobe() && !v.inMedium) kept_.push_back(v);
        return maxDepth_ < 0 || v.depth + 1 < maxDepth_;
    }

  private:
    int maxDepth_;
    std::vector<Vertex>& kept_;
};

}  // namespace

void traceLightVertices(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                        const Strategies& strategies, std::vector<Vertex>& vertices) {
    KeepVertices visitor(limits.maxDepth, vertices);
    traceLightSubpath(scene, stream, limits, strategies, visitor);
}

}  // namespace metrolux::core
