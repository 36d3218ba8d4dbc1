#pragma once
/// Curves with a thickness, as meshes of tubes: rings of a few vertices around the curve, with the normals of
/// a round one. The rings are a little wider than the curve, so that a straight tube has the area of its
/// cylinder, 2 pi r l, and seen from all around its mean width. The ends are open.

#include "io/mesh_io.h"

#include <array>

namespace metrolux::core {

/// A point of the middle line, or a control point of it, with the radius there.
struct CurvePoint {
    Vec3d p;
    double radius = 0;
};
CurvePoint operator+(const CurvePoint& a, const CurvePoint& b);
CurvePoint operator*(double factor, const CurvePoint& a);

/// A cubic piece in Bezier form.
using CurveSpan = std::array<CurvePoint, 4>;
/// The pieces of a uniform cubic B-spline: one for every four control points that follow each other.
std::vector<CurveSpan> spansOfBSpline(std::span<const CurvePoint> points);

/// Collects curves in one mesh.
class TubeMesh {
  public:
    /// `points`: about how many there will be in all. More than some 100,000 have fewer vertices in a ring.
    explicit TubeMesh(size_t points);
    /// Pieces that go on from each other.
    void addSmooth(std::span<const CurveSpan> spans);
    /// Straight pieces from point to point, mitred where they meet.
    void addLinear(std::span<const CurvePoint> points);
    /// In the space of the curves, unfinished (finishMesh).
    std::shared_ptr<TriangleMesh> take() { return std::move(mesh_); }
    size_t bytes() const;

  private:
    /// A place along a curve. `along` is the direction of the tube, `cut` the normal of the plane of the
    /// ring.
    struct Ring {
        Vec3d center, along, cut;
        double radius = 0, slope = 0;  ///< and its derivative by length
        double position = 0;           ///< from 0 to 1, for uv
    };
    void addRing(const Ring& ring, const Vec3d& axis);
    void join();

    int sides_;
    std::shared_ptr<TriangleMesh> mesh_ = std::make_shared<TriangleMesh>();
};

/// Control points of a text file: "x y z radius" a line, an empty line between two curves. With a `radius`
/// the lines are "x y z". Throws Error.
std::vector<std::vector<CurvePoint>> readCurves(const std::filesystem::path& path, const MeshOptions& options,
                                                std::optional<double> radius = std::nullopt);

}  // namespace metrolux::core
