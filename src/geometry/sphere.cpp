#include "base/frame.h"
#include "base/warp.h"
#include "geometry/affine.h"
#include "geometry/shape.h"

namespace metrolux::core {

namespace {

class Sphere final : public AnalyticShape {
  public:
    Sphere(const Transform& toWorld, const Vec3d& center, float radius, bool flipNormals)
        : flip_(flipNormals) {
        if (!(radius > 0) || !std::isfinite(radius))
            throw Error("sphere: the radius is {}, expected > 0", radius);
        const Affine map(toWorld);
        center_ = map.point(center);
        const double scale = map.x.length();
        const double skew =
            std::max({std::abs(map.x.dot(map.y)), std::abs(map.x.dot(map.z)), std::abs(map.y.dot(map.z)),
                      std::abs(map.y.length2() - scale * scale), std::abs(map.z.length2() - scale * scale)});
        if (!(skew <= 1e-3 * scale * scale))
            throw Error(
                "sphere: to_world must be a rotation, translation and uniform scale; it has shear or unequal "
                "scales ({}, {}, {})",
                scale, map.y.length(), map.z.length());
        radius_ = scale * radius;
        // A map that mirrors is split into a rotation and a scale by -radius, which turns the normals:
        // Mitsuba's polar decomposition does so.
        const double sign = toWorld.determinant3() < 0 ? -1 : 1;
        if (sign < 0) flip_ = !flip_;
        axes_[0] = map.x * (sign / scale), axes_[1] = map.y * (sign / scale),
        axes_[2] = map.z * (sign / scale);
        area_ = static_cast<float>(4 * kPiD * radius_ * radius_);
    }

    float area() const override { return area_; }

    Partials partialsAt(const SurfaceInteraction& si) const override {
        const double phi = 2 * kPiD * static_cast<double>(si.uv.x),
                     theta = kPiD * static_cast<double>(si.uv.y);
        const double x = std::cos(phi), y = std::sin(phi), rho = std::sin(theta), z = std::cos(theta);
        return {derivativeByU(rho * x, rho * y), scaledToWorld(kPiD * z * x, kPiD * z * y, -kPiD * rho)};
    }

    void bounds(Vec3f& lower, Vec3f& upper) const override {
        boundsAround(center_, Vec3d(radius_), lower, upper);
    }

    bool intersect(const Ray& ray, float tMin, float& t, SurfaceInteraction* si) const override {
        const Vec3d o = toDouble(ray.origin) - center_, d = toDouble(ray.direction);
        const double inverseA = 1.0 / d.length2();
        const double closest = -o.dot(d) * inverseA;
        const Vec3d perpendicular = o + d * closest;  // avoids the cancellation of b^2 - 4ac for far spheres
        const double square = (radius_ * radius_ - perpendicular.length2()) * inverseA;
        if (!(square >= 0)) return false;
        const double half = std::sqrt(square);
        double hit = closest - half;
        if (!(hit > tMin)) hit = closest + half;
        if (!(hit > tMin && hit < t)) return false;
        t = static_cast<float>(hit);
        if (si) fill((o + d * hit).normalized(), *si);
        return true;
    }

    ShapeSample sampleArea(const Vec2f& u) const override {
        ShapeSample result;
        fill(toDouble(warp::squareToSphere(u)).normalized(), result.si);
        result.pdfArea = 1.0f / area_;
        return result;
    }

    /// Uniform in the cone of directions that the sphere fills, from outside; uniform over the area from
    /// inside.
    std::optional<ShapeSample> sampleToward(const Vec3f& reference, const Vec2f& u) const override {
        double oneMinusCosMax;
        if (!coneFrom(reference, oneMinusCosMax)) return sampleArea(u);
        const Vec3d axis = toDouble(reference) - center_;
        const double distance = axis.length();
        // The angle at the center between the reference and the point where a ray at angle theta to the axis
        // enters.
        const double sinMax = radius_ / distance;
        const double d = static_cast<double>(u.y) * oneMinusCosMax;
        const double sin2Theta = d * (2 - d);
        const double cosAtSurface = std::sqrt(std::max(0.0, 1 - sin2Theta / (sinMax * sinMax)));
        const double cosAlpha = sin2Theta / sinMax + (1 - d) * cosAtSurface;
        const double sinAlpha = std::sqrt(sin2Theta) * std::abs((1 - d) / sinMax - cosAtSurface);
        const Vec3d n = axis / distance;
        const Frame frame = Frame::fromNormal(toFloat(n));
        const double phi = 2 * kPiD * static_cast<double>(u.x);
        const Vec3d outward = toDouble(frame.s) * (sinAlpha * std::cos(phi)) +
                              toDouble(frame.t) * (sinAlpha * std::sin(phi)) + n * cosAlpha;
        ShapeSample result;
        fill(outward.normalized(), result.si);
        result.pdfArea = pdfToward(reference, result.si);
        if (!(result.pdfArea > 0)) return std::nullopt;  // at the rim, where rounding decides
        return result;
    }

    float pdfToward(const Vec3f& reference, const SurfaceInteraction& si) const override {
        double oneMinusCosMax;
        if (!coneFrom(reference, oneMinusCosMax)) return 1.0f / area_;
        const Vec3d w = toDouble(reference) - toDouble(si.p);
        const double cosine = w.dot(toDouble(flip_ ? -si.ng : si.ng));
        if (!(cosine > 0)) return 0;  // on the far side
        const double distance2 = w.length2();
        return static_cast<float>(cosine / (distance2 * std::sqrt(distance2) * 2 * kPiD * oneMinusCosMax));
    }

  private:
    /// 1 - cos of the half angle of the cone from `reference` to the sphere; false when it is inside.
    bool coneFrom(const Vec3f& reference, double& oneMinusCosMax) const {
        const double distance2 = (toDouble(reference) - center_).length2();
        if (!(distance2 > radius_ * radius_ * (1 + 1e-6))) return false;
        const double sin2Max = radius_ * radius_ / distance2;
        oneMinusCosMax = sin2Max / (1 + std::sqrt(1 - sin2Max));
        return true;
    }

    void fill(const Vec3d& outward, SurfaceInteraction& si) const {
        si.p = toFloat(center_ + outward * radius_);
        si.ng = toFloat(outward);
        const Vec3d local(axes_[0].dot(outward), axes_[1].dot(outward), axes_[2].dot(outward));
        const double rho = std::hypot(local.x, local.y);
        double phi = std::atan2(local.y, local.x);
        if (phi < 0) phi += 2 * kPiD;
        si.uv =
            Vec2f(static_cast<float>(phi / (2 * kPiD)), static_cast<float>(std::atan2(rho, local.z) / kPiD));
        if (flip_) si.ng = -si.ng;
        si.ns = si.ng;
        si.s = Frame::fromNormalAndTangent(si.ns, derivativeByU(local.x, local.y)).s;
        si.shape = this;
        si.primitive = 0;
        si.barycentric = Vec2f(0, 0);
    }

    /// The object's axes in world space, times the radius.
    Vec3f scaledToWorld(double x, double y, double z) const {
        return toFloat((axes_[0] * x + axes_[1] * y + axes_[2] * z) * radius_);
    }
    Vec3f derivativeByU(double x, double y) const { return scaledToWorld(-2 * kPiD * y, 2 * kPiD * x, 0); }

    Vec3d center_;
    double radius_ = 1;
    Vec3d axes_[3];  // orthonormal: the object's axes in world space
    bool flip_;
    float area_ = 0;
};

}  // namespace

ShapePtr makeSphere(const Transform& toWorld, const Vec3d& center, float radius, bool flipNormals) {
    return std::make_shared<Sphere>(toWorld, center, radius, flipNormals);
}

}  // namespace metrolux::core
