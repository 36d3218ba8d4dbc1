#pragma once
#include "base/direction_cone.h"
#include "base/huge_pages.h"
#include "base/math.h"
#include "base/transform.h"
#include "geometry/interaction.h"
#include "geometry/medium_sides.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace metrolux::core {

class Bsdf;
class Light;

/// A point on a shape, sampled for emission or next-event estimation.
struct ShapeSample {
    SurfaceInteraction si;
    float pdfArea = 0;  ///< density per area
};

/// Partial derivatives of position with respect to uv.
struct Partials {
    Vec3f dpdu{0.0f}, dpdv{0.0f};
};
/// Those of a surface point, in world space. Computed when asked for: only bump maps do. A point without a
/// shape has its tangents.
Partials partials(const SurfaceInteraction& si);

/// A surface: a triangle mesh or an analytic primitive, in world space.
class Shape {
  public:
    virtual ~Shape() = default;

    virtual float area() const = 0;
    /// Uniform over the area. On a mesh the shading frame is that of the geometric normal.
    virtual ShapeSample sampleArea(const Vec2f& u) const = 0;
    /// A point to be seen from `reference`; may prefer the visible part. `pdfArea` is the density per area of
    /// the result. Default: sampleArea.
    virtual std::optional<ShapeSample> sampleToward(const Vec3f& reference, const Vec2f& u) const {
        (void)reference;
        return sampleArea(u);
    }
    /// Density per area with which sampleToward(reference) picks `si`.
    virtual float pdfToward(const Vec3f& reference, const SurfaceInteraction& si) const {
        (void)reference, (void)si;
        return 1.0f / area();
    }
    /// World-space bounds.
    virtual void bounds(Vec3f& lower, Vec3f& upper) const = 0;
    /// Holds the geometric normals of all points. Default: all directions.
    virtual DirectionCone normalCone() const { return {}; }
    /// Partial derivatives of position in the shape's own space, where no instance places it.
    virtual Partials partialsAt(const SurfaceInteraction& si) const = 0;
    virtual size_t primitiveCount() const { return 1; }
    /// Interpolated mesh attribute ("vertex_color", "face_weight" ...), or nullptr if the shape does not have
    /// it.
    virtual bool attribute(const std::string& name, const SurfaceInteraction& si, Rgb& value) const {
        (void)name, (void)si, (void)value;
        return false;
    }
    /// Number of channels (1 or 3) of a mesh attribute, 0 when there is none of that name.
    virtual int attributeChannels(const std::string& name) const {
        (void)name;
        return 0;
    }

    // Set by the loader.
    std::string id;                        ///< name for messages and mattes
    std::string material;                  ///< the same of its BSDF
    std::shared_ptr<const Bsdf> bsdf;      ///< never null after loading
    std::shared_ptr<const Light> emitter;  ///< null unless the shape is an area light
    /// Nothing unless the surface bounds a medium: then the same is on both of its sides.
    std::optional<MediumSides> media;
};
using ShapePtr = std::shared_ptr<Shape>;

/// What lies beyond a surface in direction w: `medium`, what is on this side, unless the surface bounds one.
inline MediumIndex mediumBeyond(const SurfaceInteraction& si, const Vec3f& w, MediumIndex medium) {
    const std::optional<MediumSides>& sides = si.shape->media;
    if (!sides) return medium;
    return dot(w, si.ng) > 0 ? sides->exterior : sides->interior;
}

/// Triangles in world space. Normals and uv are optional. Immutable once built.
///
/// The winding orients ng: cross(p1 - p0, p2 - p0). A triangle whose vertex normals lie on the other side
/// follows them instead, whole: Mitsuba decides the sides of a surface by its shading normal alone.
class TriangleMesh final : public Shape {
  public:
    struct Attribute {
        std::string name;  ///< with its prefix: "vertex_..." or "face_..."
        int channels = 3;  ///< 1 or 3
        std::vector<float> values;
    };
    std::vector<Vec3f> positions;
    std::vector<Vec3f> normals;     ///< empty, or one per vertex
    std::vector<Vec2f> uvs;         ///< empty, or one per vertex
    std::vector<uint32_t> indices;  ///< three per triangle
    std::vector<Attribute> attributes;
    bool flipNormals = false;  ///< ng and ns point to the other side

    /// To be called when all above is set, and after changes of it: checks indices, builds the tables of
    /// areas and normals. Throws Error for indices out of range and non-finite vertices. Triangles of zero
    /// area are kept out of sampling.
    void finalize();
    /// Replaces `normals` by the mean of the adjacent faces' normals, weighted by the angle at the vertex
    /// (Thuermer & Wuethrich 1998, as Mitsuba does). To be called before finalize(), with valid indices.
    void computeVertexNormals();

    float area() const override { return totalArea_; }
    ShapeSample sampleArea(const Vec2f& u) const override;
    std::optional<ShapeSample> sampleToward(const Vec3f& reference, const Vec2f& u) const override;
    void bounds(Vec3f& lower, Vec3f& upper) const override;
    DirectionCone normalCone() const override;
    Partials partialsAt(const SurfaceInteraction& si) const override;
    size_t primitiveCount() const override { return indices.size() / 3; }
    bool attribute(const std::string& name, const SurfaceInteraction& si, Rgb& value) const override;
    int attributeChannels(const std::string& name) const override;

    /// Fills everything of `si` but the placement for the point with barycentric coordinates (b1, b2) of a
    /// triangle.
    void interaction(uint32_t triangle, const Vec2f& barycentric, SurfaceInteraction& si) const;
    /// Of what it reads besides the vertices (geometry/triangle_prefetch.h).
    const void* addressOfFace(uint32_t triangle) const { return &faces_[triangle]; }

  private:
    /// The part of interaction() that light sources need: all but the shading frame.
    void place(uint32_t triangle, const Vec2f& barycentric, SurfaceInteraction& si) const;
    void sampleAreaInto(const Vec2f& u, ShapeSample& result) const;
    /// Unit normal of the triangle with these vertices; `scaled`: cross product of its edges.
    Vec3f geometricNormal(const uint32_t* vertices, const Imath::V3d& scaled) const;

    float totalArea_ = 0;
    std::vector<double> areaCdf_;
    /// What is the same for all points of a triangle.
    struct Face {
        Vec3f normal;   ///< ng
        Vec3f tangent;  ///< along dp/du, or any
    };
    std::vector<Face, HugePageAllocator<Face>> faces_;
};

/// Sphere, disk and cylinder: intersected by Embree's user-geometry callbacks.
class AnalyticShape : public Shape {
  public:
    /// Nearest intersection with tMin < t' < t; t becomes t'. Distances are in units of ray.direction, which
    /// need not be of unit length here (rays are transformed into the space of an instance). `si`, if not
    /// null, is filled.
    virtual bool intersect(const Ray& ray, float tMin, float& t, SurfaceInteraction* si) const = 0;
};

/// `radius` > 0. The map may rotate, translate and scale uniformly. uv as in Mitsuba.
ShapePtr makeSphere(const Transform& toWorld, const Vec3d& center, float radius, bool flipNormals);
/// The unit disk in the xy plane, normal +z, under any affine map.
ShapePtr makeDisk(const Transform& toWorld, bool flipNormals);
/// Cylinder from p0 to p1, without caps, normals to the outside.
ShapePtr makeCylinder(const Transform& toWorld, const Vec3d& p0, const Vec3d& p1, float radius,
                      bool flipNormals);
/// The square [-1,1]^2 in the xy plane, normal +z, as two triangles.
ShapePtr makeRectangle(const Transform& toWorld, bool flipNormals);
/// The cube [-1,1]^3, normals outside, uv in [0,1]^2 on each face, flat shading.
ShapePtr makeCube(const Transform& toWorld, bool flipNormals);

/// A group of shapes that instances place.
struct ShapeGroup {
    std::vector<ShapePtr> shapes;
};
struct Instance {
    std::shared_ptr<const ShapeGroup> group;
    Transform toWorld;
};

}  // namespace metrolux::core
