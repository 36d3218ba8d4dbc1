#include "base/frame.h"
#include "geometry/affine.h"
#include "geometry/shape.h"

namespace metrolux::core {

namespace {

/// Cylinder of circular section without caps; uv = (angle / 2 pi, height). In its local space the radius and
/// the length are one.
class Cylinder final : public AnalyticShape {
  public:
    Cylinder(const Transform& toWorld, const Vec3d& p0, const Vec3d& p1, float radius, bool flipNormals) {
        const Vec3f axis = toFloat(p1 - p0);
        if (!(radius > 0) || !std::isfinite(radius))
            throw Error("cylinder: the radius is {}, expected > 0", radius);
        if (!(lengthSquared(axis) > 0) || !isFinite(axis)) throw Error("cylinder: p0 and p1 must differ");
        const Frame frame = Frame::fromNormal(normalize(axis));
        const double r = radius;
        const Vec3d s = toDouble(frame.s) * r, t = toDouble(frame.t) * r, z = toDouble(axis);
        const Transform toObject = Transform::fromRows(
            {{s.x, t.x, z.x, p0.x}, {s.y, t.y, z.y, p0.y}, {s.z, t.z, z.z, p0.z}, {0, 0, 0, 1}});
        const Transform map = toWorld * toObject;
        toWorld_ = Affine(map);
        toLocal_ = Affine(map.inverse());
        radius_ = toWorld_.x.length();
        length_ = toWorld_.z.length();
        const double tolerance = 1e-3;
        if (std::abs(toWorld_.y.length() - radius_) > tolerance * radius_ ||
            std::abs(toWorld_.x.dot(toWorld_.y)) > tolerance * radius_ * radius_ ||
            std::abs(toWorld_.x.dot(toWorld_.z)) > tolerance * radius_ * length_ ||
            std::abs(toWorld_.y.dot(toWorld_.z)) > tolerance * radius_ * length_)
            throw Error(
                "cylinder: to_world must keep the section a circle that is perpendicular to the axis");
        // Mitsuba takes the normal from the tangents, so that a map that mirrors turns it inside.
        outwardSign_ = (map.determinant3() < 0) != flipNormals ? -1.0f : 1.0f;
        area_ = static_cast<float>(2 * kPiD * radius_ * length_);
    }

    float area() const override { return area_; }

    Partials partialsAt(const SurfaceInteraction& si) const override {
        const double phi = 2 * kPiD * static_cast<double>(si.uv.x);
        return {derivativeByU(std::cos(phi), std::sin(phi)), toFloat(toWorld_.z)};
    }

    void bounds(Vec3f& lower, Vec3f& upper) const override {
        Vec3d extent;
        for (int i = 0; i < 3; ++i)
            extent[i] = std::hypot(toWorld_.x[i], toWorld_.y[i]) + 0.5 * std::abs(toWorld_.z[i]);
        boundsAround(toWorld_.offset + toWorld_.z * 0.5, extent, lower, upper);
    }

    bool intersect(const Ray& ray, float tMin, float& t, SurfaceInteraction* si) const override {
        const Vec3d o = toLocal_.point(toDouble(ray.origin)), d = toLocal_.vector(toDouble(ray.direction));
        const double a = d.x * d.x + d.y * d.y;
        if (!(a > 0)) return false;
        const double closest = -(o.x * d.x + o.y * d.y) / a;
        const double x = o.x + closest * d.x, y = o.y + closest * d.y;
        const double square = (1 - x * x - y * y) / a;
        if (!(square >= 0)) return false;
        const double half = std::sqrt(square);
        for (const double hit : {closest - half, closest + half}) {
            const double z = o.z + hit * d.z;
            if (!(hit > tMin && hit < t && z >= 0 && z <= 1)) continue;
            t = static_cast<float>(hit);
            if (si) fill(o.x + hit * d.x, o.y + hit * d.y, z, *si);
            return true;
        }
        return false;
    }

    ShapeSample sampleArea(const Vec2f& u) const override {
        const double phi = 2 * kPiD * static_cast<double>(u.y);
        ShapeSample result;
        fill(std::cos(phi), std::sin(phi), u.x, result.si);
        result.pdfArea = 1.0f / area_;
        return result;
    }

  private:
    void fill(double x, double y, double z, SurfaceInteraction& si) const {
        const double rho = std::hypot(x, y);
        x /= rho, y /= rho;
        si.p = toFloat(toWorld_.point({x, y, z}));
        double u = std::atan2(y, x) / (2 * kPiD);
        if (u < 0) u += 1;
        si.uv = Vec2f(static_cast<float>(u), static_cast<float>(z));
        si.ng = normalize(toFloat(toWorld_.vector({x, y, 0}))) * outwardSign_;
        si.ns = si.ng;
        si.s = Frame::fromNormalAndTangent(si.ns, derivativeByU(x, y)).s;
        si.shape = this;
        si.primitive = 0;
        si.barycentric = Vec2f(0, 0);
    }

    Vec3f derivativeByU(double x, double y) const {
        return toFloat(toWorld_.vector({-2 * kPiD * y, 2 * kPiD * x, 0}));
    }

    Affine toWorld_, toLocal_;
    double radius_ = 1, length_ = 1;
    float outwardSign_ = 1;
    float area_ = 0;
};

}  // namespace

ShapePtr makeCylinder(const Transform& toWorld, const Vec3d& p0, const Vec3d& p1, float radius,
                      bool flipNormals) {
    return std::make_shared<Cylinder>(toWorld, p0, p1, radius, flipNormals);
}

}  // namespace metrolux::core
