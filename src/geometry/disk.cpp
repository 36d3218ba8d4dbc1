#include "base/warp.h"
#include "geometry/affine.h"
#include "geometry/shape.h"

namespace metrolux::core {

namespace {

/// A disk or, under a map that is no similarity, an ellipse. uv = (radius, angle / 2 pi).
class Disk final : public AnalyticShape {
  public:
    Disk(const Transform& toWorld, bool flipNormals)
        : toWorld_(toWorld), normal_(normalize(toWorld.normal(Vec3f(0, 0, 1)))) {
        if (!(lengthSquared(normal_) > 0)) throw Error("disk: to_world leaves it no area");
        toLocal_ = Affine(toWorld.isSingular() ? withHeight().inverse() : toWorld.inverse());
        if (flipNormals) normal_ = -normal_;
        area_ = static_cast<float>(std::numbers::pi * toWorld_.x.cross(toWorld_.y).length());
    }

    float area() const override { return area_; }

    Partials partialsAt(const SurfaceInteraction& si) const override {
        const double phi = 2 * std::numbers::pi * static_cast<double>(si.uv.y);
        const double x = std::cos(phi), y = std::sin(phi);
        // Mitsuba leaves out the factor 2 pi r of dpdv; bump maps depend on it.
        return {toFloat(toWorld_.vector({x, y, 0})), toFloat(toWorld_.vector({-y, x, 0}))};
    }

    void bounds(Vec3f& lower, Vec3f& upper) const override {
        Vec3d extent;
        for (int i = 0; i < 3; ++i) extent[i] = std::hypot(toWorld_.x[i], toWorld_.y[i]);
        boundsAround(toWorld_.offset, extent, lower, upper);
    }

    DirectionCone normalCone() const override { return {normal_, 1}; }

    bool intersect(const Ray& ray, float tMin, float& t, SurfaceInteraction* si) const override {
        const Vec3d o = toLocal_.point(toDouble(ray.origin)), d = toLocal_.vector(toDouble(ray.direction));
        const double hit = -o.z / d.z;
        if (!(hit > tMin && hit < t)) return false;
        const double x = o.x + hit * d.x, y = o.y + hit * d.y;
        if (!(x * x + y * y <= 1)) return false;
        t = static_cast<float>(hit);
        if (si) fill(x, y, *si);
        return true;
    }

    ShapeSample sampleArea(const Vec2f& u) const override {
        const Vec2f p = warp::squareToDisk(u);
        ShapeSample result;
        fill(p.x, p.y, result.si);
        result.pdfArea = 1.0f / area_;
        return result;
    }

  private:
    /// The map with the normal as the image of z: a disk has no height that the map could flatten.
    Transform withHeight() const {
        const Vec3d &x = toWorld_.x, &y = toWorld_.y, &o = toWorld_.offset;
        return Transform::fromRows({{x.x, y.x, normal_.x, o.x},
                                    {x.y, y.y, normal_.y, o.y},
                                    {x.z, y.z, normal_.z, o.z},
                                    {0, 0, 0, 1}});
    }

    void fill(double x, double y, SurfaceInteraction& si) const {
        si.p = toFloat(toWorld_.point({x, y, 0}));
        si.ng = si.ns = normal_;
        const double r = std::hypot(x, y);
        double v = std::atan2(y, x) / (2 * std::numbers::pi);
        if (v < 0) v += 1;
        si.uv = Vec2f(static_cast<float>(r), static_cast<float>(v));
        const Vec3d radial = r > 0 ? Vec3d(x / r, y / r, 0) : Vec3d(1, 0, 0);
        si.s = Frame::fromNormalAndTangent(si.ns, toFloat(toWorld_.vector(radial))).s;
        si.shape = this;
        si.primitive = 0;
        si.barycentric = Vec2f(0, 0);
    }

    Affine toWorld_, toLocal_;
    Vec3f normal_;
    float area_ = 0;
};

}  // namespace

ShapePtr makeDisk(const Transform& toWorld, bool flipNormals) {
    return std::make_shared<Disk>(toWorld, flipNormals);
}

}  // namespace metrolux::core
