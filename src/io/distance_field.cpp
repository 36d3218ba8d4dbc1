#include "io/distance_field.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <unordered_map>

namespace metrolux::core {
namespace {

constexpr int kCellsAcross = 100, kMostParts = 4;
constexpr uint64_t kCellBytes = 1024;  // 12 triangles and their vertices, found by their edges

/// Corner c of a cell is at (c & 1, c >> 1 & 1, c >> 2). All six share the diagonal from 0 to 7, and
/// neighbors divide the face between them in the same way.
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                   {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

class Field {
  public:
    explicit Field(const GridSamples& samples) : s_(samples) {}

    /// Trilinear, at a point in units of cells.
    float value(const Vec3f& p) const;
    /// Trilinear between the central differences at the nodes, in the unit cube's units.
    Vec3f gradient(const Vec3f& p) const;

  private:
    float at(int x, int y, int z) const {
        const auto& n = s_.resolution;
        return s_.values[(size_t(z) * size_t(n.y) + size_t(y)) * size_t(n.x) + size_t(x)];
    }
    float difference(int x, int y, int z, int axis) const {
        Imath::V3i low(x, y, z), high(x, y, z);
        low[axis] = std::max(low[axis] - 1, 0);
        high[axis] = std::min(high[axis] + 1, s_.resolution[axis] - 1);
        const auto cells = static_cast<float>(s_.resolution[axis] - 1);
        return (at(high.x, high.y, high.z) - at(low.x, low.y, low.z)) * cells /
               static_cast<float>(high[axis] - low[axis]);
    }
    template <class Node>
    auto interpolated(const Vec3f& p, const Node& node) const {
        int cell[3];
        float t[3];
        for (int a = 0; a < 3; ++a) {
            cell[a] = std::clamp(static_cast<int>(p[a]), 0, s_.resolution[a] - 2);
            t[a] = p[a] - static_cast<float>(cell[a]);
        }
        const auto along = [&](int y, int z) {
            return node(cell[0], y, z) * (1 - t[0]) + node(cell[0] + 1, y, z) * t[0];
        };
        const auto across = [&](int z) {
            return along(cell[1], z) * (1 - t[1]) + along(cell[1] + 1, z) * t[1];
        };
        return across(cell[2]) * (1 - t[2]) + across(cell[2] + 1) * t[2];
    }

    const GridSamples& s_;
};

float Field::value(const Vec3f& p) const {
    return interpolated(p, [&](int x, int y, int z) { return at(x, y, z); });
}

Vec3f Field::gradient(const Vec3f& p) const {
    return interpolated(p, [&](int x, int y, int z) {
        return Vec3f(difference(x, y, z, 0), difference(x, y, z, 1), difference(x, y, z, 2));
    });
}

class Surface {
  public:
    Surface(const GridSamples& samples, bool smooth)
        : field_(samples), resolution_(samples.resolution), smooth_(smooth) {
        const int longest = std::max({resolution_.x, resolution_.y, resolution_.z}) - 1;
        parts_ = std::clamp(kCellsAcross / longest, 1, kMostParts);
        for (int a = 0; a < 3; ++a) cells_[a] = (resolution_[a] - 1) * parts_;
    }

    uint64_t countCells() const {
        uint64_t count = 0;
        forEachCut([&](const Imath::V3i&, const Corners&) { ++count; });
        return count;
    }

    std::shared_ptr<TriangleMesh> run() {
        forEachCut([&](const Imath::V3i& origin, const Corners& f) {
            for (const auto& tetrahedron : kTetrahedra) divide(origin, f, tetrahedron);
        });
        return std::move(mesh_);
    }

  private:
    using Corners = std::array<float, 8>;

    /// The cells through which the surface goes, with the values at their corners.
    template <class Visit>
    void forEachCut(const Visit& visit) const {
        std::vector<float> below = layer(0);
        for (int z = 0; z < cells_.z; ++z) {
            const std::vector<float> above = layer(z + 1);
            for (int y = 0; y < cells_.y; ++y)
                for (int x = 0; x < cells_.x; ++x) {
                    Corners f;
                    int inside = 0;
                    for (int c = 0; c < 8; ++c) {
                        const Imath::V3i node = corner({x, y, z}, c);
                        const auto i = static_cast<size_t>(c);
                        f[i] = (c < 4 ? below : above)[inLayer(node.x, node.y)];
                        inside += f[i] < 0;
                    }
                    if (inside > 0 && inside < 8) visit(Imath::V3i(x, y, z), f);
                }
            below = above;
        }
    }

    Vec3f position(const Imath::V3i& node) const { return Vec3f(node) * (1.0f / static_cast<float>(parts_)); }
    size_t inLayer(int x, int y) const { return size_t(y) * size_t(cells_.x + 1) + size_t(x); }

    /// The values at the nodes of one z.
    std::vector<float> layer(int z) const {
        std::vector<float> result(inLayer(0, cells_.y + 1));
        for (int y = 0; y <= cells_.y; ++y)
            for (int x = 0; x <= cells_.x; ++x) result[inLayer(x, y)] = field_.value(position({x, y, z}));
        return result;
    }

    static Imath::V3i corner(const Imath::V3i& cell, int c) {
        return cell + Imath::V3i(c & 1, c >> 1 & 1, c >> 2);
    }

    void divide(const Imath::V3i& origin, const Corners& f, const int (&t)[4]) {
        int in[4], out[4], inside = 0, outside = 0;
        for (const int c : t) {
            if (f[static_cast<size_t>(c)] < 0)
                in[inside++] = c;
            else
                out[outside++] = c;
        }
        const auto cut = [&](int a, int b) { return vertex(origin, f, a, b); };
        if (inside == 1) triangle(cut(in[0], out[0]), cut(in[0], out[1]), cut(in[0], out[2]));
        if (inside == 3) triangle(cut(in[0], out[0]), cut(in[1], out[0]), cut(in[2], out[0]));
        if (inside != 2) return;
        const uint32_t a = cut(in[0], out[0]), b = cut(in[0], out[1]), c = cut(in[1], out[1]),
                       d = cut(in[1], out[0]);
        triangle(a, b, c);
        triangle(a, c, d);
    }

    /// Of the edge between two corners, the lower one first: one edge has one vertex.
    uint32_t vertex(const Imath::V3i& origin, const Corners& f, int a, int b) {
        if (a > b) std::swap(a, b);
        const Imath::V3i low = corner(origin, a);
        const uint64_t node =
            (uint64_t(low.z) * uint64_t(cells_.y + 1) + uint64_t(low.y)) * uint64_t(cells_.x + 1) +
            uint64_t(low.x);
        const auto [entry, isNew] =
            vertices_.try_emplace(node * 8 + uint64_t(b - a), static_cast<uint32_t>(mesh_->positions.size()));
        if (!isNew) return entry->second;
        const float fa = f[static_cast<size_t>(a)], fb = f[static_cast<size_t>(b)];
        const Vec3f p = lerp(fa / (fa - fb), position(low), position(corner(origin, b)));
        Vec3f unit;
        for (int k = 0; k < 3; ++k) unit[k] = p[k] / static_cast<float>(resolution_[k] - 1);
        mesh_->positions.push_back(unit);
        gradients_.push_back(field_.gradient(p));
        if (smooth_) mesh_->normals.push_back(normalize(gradients_.back()));
        return entry->second;
    }

    void triangle(uint32_t a, uint32_t b, uint32_t c) {
        const auto& p = mesh_->positions;
        const Vec3f normal = cross(p[b] - p[a], p[c] - p[a]);
        if (!(lengthSquared(normal) > 0)) return;
        if (dot(normal, gradients_[a] + gradients_[b] + gradients_[c]) < 0) std::swap(b, c);
        mesh_->indices.insert(mesh_->indices.end(), {a, b, c});
    }

    Field field_;
    Imath::V3i resolution_, cells_{0};
    int parts_ = 1;
    bool smooth_;
    std::unordered_map<uint64_t, uint32_t> vertices_;
    std::vector<Vec3f> gradients_;
    std::shared_ptr<TriangleMesh> mesh_ = std::make_shared<TriangleMesh>();
};

}  // namespace

std::shared_ptr<TriangleMesh> meshOfDistances(const GridSamples& samples, bool smooth,
                                              const std::function<void(uint64_t)>& book) {
    if (samples.channels != 1) throw Error("found {} channels, expected 1", samples.channels);
    for (int a = 0; a < 3; ++a)
        if (samples.resolution[a] < 2)
            throw Error("found {} samples along {}, expected 2 at least", samples.resolution[a], "xyz"[a]);
    Surface surface(samples, smooth);
    book(surface.countCells() * kCellBytes);
    auto mesh = surface.run();
    if (mesh->indices.empty()) throw Error("the distances have no zero: there is no surface");
    return mesh;
}

}  // namespace metrolux::core
