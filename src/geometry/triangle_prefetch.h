#pragma once
/// Asking for the memory that TriangleMesh::interaction() will read, ahead of time: first for what leads to
/// the vertices, then, when that is there, for the vertices.

#include "base/prefetch.h"
#include "geometry/shape.h"

namespace metrolux::core {

inline void prefetchFace(const TriangleMesh& mesh, uint32_t triangle) {
    prefetch(&mesh.indices[3 * size_t(triangle)]);
    prefetch(mesh.addressOfFace(triangle));
}

inline void prefetchVertices(const TriangleMesh& mesh, uint32_t triangle) {
    for (int corner = 0; corner < 3; ++corner) {
        const uint32_t v = mesh.indices[3 * size_t(triangle) + corner];
        prefetch(&mesh.positions[v]);
        if (!mesh.normals.empty()) prefetch(&mesh.normals[v]);
        if (!mesh.uvs.empty()) prefetch(&mesh.uvs[v]);
    }
}

}  // namespace metrolux::core
