#include "io/mesh_smoothing.h"

#include "base/error.h"
#include "geometry/affine.h"

#include <algorithm>
#include <numeric>

namespace metrolux::core {
namespace {

constexpr size_t kMostFaces = 4096;  // of a vertex: they are compared with each other

bool isOfVertices(const TriangleMesh::Attribute& a) { return a.name.starts_with("vertex_"); }

/// Three-way comparison of all that two vertices have.
class VertexOrder {
  public:
    explicit VertexOrder(const TriangleMesh& mesh) : mesh_(mesh) {}

    int compare(uint32_t a, uint32_t b) const {
        if (const int c = compare(&mesh_.positions[a].x, &mesh_.positions[b].x, 3)) return c;
        if (!mesh_.uvs.empty())
            if (const int c = compare(&mesh_.uvs[a].x, &mesh_.uvs[b].x, 2)) return c;
        for (const TriangleMesh::Attribute& attribute : mesh_.attributes) {
            if (!isOfVertices(attribute)) continue;
            const auto n = static_cast<size_t>(attribute.channels);
            if (const int c = compare(&attribute.values[a * n], &attribute.values[b * n], n)) return c;
        }
        return 0;
    }

  private:
    static int compare(const float* a, const float* b, size_t count) {
        for (size_t i = 0; i < count; ++i)
            if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
        return 0;
    }
    const TriangleMesh& mesh_;
};

/// For each vertex the first one that equals it.
std::vector<uint32_t> firstEquals(const TriangleMesh& mesh) {
    const VertexOrder order(mesh);
    std::vector<uint32_t> sorted(mesh.positions.size());
    std::iota(sorted.begin(), sorted.end(), 0u);
    std::sort(sorted.begin(), sorted.end(), [&](uint32_t a, uint32_t b) {
        const int c = order.compare(a, b);
        return c != 0 ? c < 0 : a < b;
    });
    std::vector<uint32_t> first(sorted.size());
    for (size_t i = 0; i < sorted.size(); ++i)
        first[sorted[i]] =
            i > 0 && order.compare(sorted[i - 1], sorted[i]) == 0 ? first[sorted[i - 1]] : sorted[i];
    return first;
}

/// The places in `indices` of the corners at each vertex, in ascending order.
struct CornersOfVertices {
    std::vector<size_t> begin, corners;

    CornersOfVertices(const TriangleMesh& mesh, const std::vector<uint32_t>& first)
        : begin(mesh.positions.size() + 1, 0), corners(mesh.indices.size()) {
        for (const uint32_t v : mesh.indices) ++begin[first[v] + 1];
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        std::vector<size_t> next(begin.begin(), begin.end() - 1);
        for (size_t i = 0; i < mesh.indices.size(); ++i) corners[next[first[mesh.indices[i]]]++] = i;
    }
};

Vec3d faceNormal(const TriangleMesh& mesh, size_t triangle) {
    const uint32_t* v = &mesh.indices[3 * triangle];
    const Vec3d p = toDouble(mesh.positions[v[0]]);
    return (toDouble(mesh.positions[v[1]]) - p).cross(toDouble(mesh.positions[v[2]]) - p).normalized();
}

/// The mesh with vertex i of the result taken from vertex origin[i].
template <class T>
void gather(std::vector<T>& values, const std::vector<uint32_t>& origin, size_t each) {
    if (values.empty()) return;
    std::vector<T> result;
    result.reserve(origin.size() * each);
    for (const uint32_t v : origin)
        for (size_t k = 0; k < each; ++k) result.push_back(values[v * each + k]);
    values = std::move(result);
}

}  // namespace

void splitAtSharpEdges(TriangleMesh& mesh, float degrees) {
    const double nearest = std::cos(static_cast<double>(degrees) * (std::numbers::pi / 180));
    const CornersOfVertices around(mesh, firstEquals(mesh));
    std::vector<uint32_t> origin, indices(mesh.indices.size());
    struct Group {
        Vec3d normal;
        uint32_t vertex;
    };
    std::vector<Group> groups;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
        groups.clear();
        if (around.begin[v + 1] - around.begin[v] > kMostFaces)
            throw Error("more than {} faces meet in vertex {}: max_smooth_angle is not for such meshes",
                        kMostFaces, v);
        for (size_t i = around.begin[v]; i < around.begin[v + 1]; ++i) {
            const size_t corner = around.corners[i];
            const Vec3d n = faceNormal(mesh, corner / 3);
            auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
                return g.normal == n || g.normal.dot(n) > nearest;
            });
            if (group == groups.end()) {
                groups.push_back({n, static_cast<uint32_t>(origin.size())});
                origin.push_back(v);
                group = groups.end() - 1;
            }
            indices[corner] = group->vertex;
        }
    }
    gather(mesh.positions, origin, 1);
    gather(mesh.uvs, origin, 1);
    for (TriangleMesh::Attribute& attribute : mesh.attributes)
        if (isOfVertices(attribute))
            gather(attribute.values, origin, static_cast<size_t>(attribute.channels));
    mesh.indices = std::move(indices);
}

}  // namespace metrolux::core
