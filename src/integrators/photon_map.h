#pragma once
#include "sampling/sample_stream.h"
#include "spatial/vertex_grid.h"
#include "transport/subpath.h"

namespace metrolux::core {

/// Light vertices that eye subpaths are merged with: the set L of the supplement, section 4.1.1. The
/// throughput of a vertex carries the weight of its light subpath, such that a sum over the set is an
/// estimate from all of them.
class PhotonMap {
  public:
    /// Takes the vertices; `radius` of merging, > 0.
    void build(std::vector<Vertex> vertices, float radius);
    size_t size() const { return vertices_.size(); }
    size_t memoryBytes() const { return vertices_.capacity() * sizeof(Vertex) + grid_.memoryBytes(); }

    /// Sum of the merges of an eye vertex, weighted by multiple importance sampling, with those that no wall
    /// keeps apart from it. `maxDepth`: largest number of path edges, -1: no limit.
    Rgb merge(const Scene& scene, const Strategies& strategies, const Vertex& eye, int maxDepth) const;

  private:
    std::vector<Vertex> vertices_;
    VertexGrid grid_;
    double inverseDiskArea_ = 0;
};

/// Traces a light subpath and appends those of its vertices that can be merged.
void traceLightVertices(const Scene& scene, SampleStream& stream, const PathLimits& limits,
                        const Strategies& strategies, std::vector<Vertex>& vertices);

}  // namespace metrolux::core
