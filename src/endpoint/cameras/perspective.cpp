#include "base/error.h"
#include "base/warp.h"
#include "endpoint/camera.h"

namespace metrolux::core {

namespace {

/// Pinhole and thin lens are one model: the lens of a pinhole has radius zero.
///
/// A raster position names a point of the plane in focus. At a fixed lens point, a unit of raster area is
/// pixelSide^2 F^2 on the plane at distance F, which is seen under cos^3 / F^2 of a steradian per area: so
/// d(raster area)/d(solid angle) = 1 / (pixelSide^2 cos^3), whatever F and the lens point are.
class PerspectiveCamera final : public Camera {
  public:
    PerspectiveCamera(const PerspectiveParameters& p, const FilmWindow& window)
        : Camera(window),
          origin_(p.toWorld.point(Vec3f(0.0f))),
          x_(normalize(p.toWorld.vector({1, 0, 0}))),
          y_(normalize(p.toWorld.vector({0, 1, 0}))),
          z_(normalize(p.toWorld.vector({0, 0, 1}))),
          nearClip_(p.nearClip),
          lensRadius_(p.apertureRadius),
          focus_(p.focusDistance),
          offset_(p.principalOffsetX, p.principalOffsetY) {
        requireFilm(window, "perspective");
        const float width = static_cast<float>(window.fullWidth),
                    height = static_cast<float>(window.fullHeight);
        if (!(nearClip_ >= 0)) throw Error("perspective camera: near clip {} is negative", nearClip_);
        if (!(lensRadius_ >= 0))
            throw Error("perspective camera: aperture radius {} is negative", lensRadius_);
        if (!(focus_ > 0)) throw Error("perspective camera: focus distance {} is not positive", focus_);
        pixelSide_ = 2 * perspectiveHalfWidth(p.fov, p.axis, width / height) / width;
        lensPdf_ = lensRadius_ > 0 ? 1.0f / (kPi * sqr(lensRadius_)) : 1.0f;
    }

    std::optional<EndpointRay> sampleRay(const Vec2f& uLens, const Vec2f& raster) const override {
        const Vec2f lens = lensPoint(uLens);
        const Vec2f plane = planeFromRaster(raster);
        const Vec3f local = normalize(Vec3f(plane.x - lens.x / focus_, plane.y - lens.y / focus_, 1));
        EndpointRay ray;
        ray.direction = normalize(toWorld(local));
        ray.origin = origin_ + x_ * lens.x + y_ * lens.y + ray.direction * (nearClip_ / local.z);
        ray.weight = Rgb(1.0f);
        ray.pdfPosition = lensPdf_;
        ray.pdfDirection = rasterPerSolidAngle(local.z) / static_cast<float>(window_.pixelCount());
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f& uLens) const override {
        const Vec3f d = x - origin_;
        const Vec2f lens = lensPoint(uLens);
        const Vec3f local(dot(d, x_) - lens.x, dot(d, y_) - lens.y, dot(d, z_));
        if (!(local.z > nearClip_)) return std::nullopt;
        const Vec2f plane((lens.x / focus_) + local.x / local.z, (lens.y / focus_) + local.y / local.z);
        EndpointConnection c;
        c.filmPosition = rasterFromPlane(plane);
        if (!(c.filmPosition.x >= 0 && c.filmPosition.x < static_cast<float>(window_.fullWidth) &&
              c.filmPosition.y >= 0 && c.filmPosition.y < static_cast<float>(window_.fullHeight)))
            return std::nullopt;
        const Vec3f lensWorld = origin_ + x_ * lens.x + y_ * lens.y;
        c.distance = local.length();
        const float cosine = local.z / c.distance;
        c.wi = normalize(lensWorld - x);
        c.point = lensWorld - c.wi * (nearClip_ / cosine);
        const float importance = rasterPerSolidAngle(cosine);
        c.value = Rgb(importance / sqr(c.distance));
        c.pdfPosition = lensPdf_;
        c.pdfDirection = importance / static_cast<float>(window_.pixelCount());
        return c;
    }

    float pixelFootprint(float distance) const override { return pixelSide_ * distance; }
    Vec3f position() const override { return origin_; }
    std::optional<Matrices> matrices() const override {
        const auto row = [&](const Vec3f& axis) { return Row{axis, -dot(axis, origin_)}; };
        const Row right = row(-x_), up = row(y_), forward = row(z_), one{Vec3f(0.0f), 1};
        const float w = pixelSide_ * static_cast<float>(window_.fullWidth),
                    h = pixelSide_ * static_cast<float>(window_.fullHeight);
        return Matrices{matrixOf(right, up, forward, one),
                        matrixOf(row(z_ * (0.5f - offset_.x) - x_ * (1 / w)),
                                 row(z_ * (0.5f - offset_.y) - y_ * (1 / h)), forward, forward)};
    }
    Vec3f projectionCenter(const Vec3f& origin, const Vec3f& direction) const override {
        return origin - direction * (nearClip_ / dot(direction, z_));
    }

  private:
    Vec3f toWorld(const Vec3f& v) const { return x_ * v.x + y_ * v.y + z_ * v.z; }
    Vec2f lensPoint(const Vec2f& u) const {
        return lensRadius_ > 0 ? warp::squareToDisk(u) * lensRadius_ : Vec2f(0.0f);
    }
    float rasterPerSolidAngle(float cosine) const {
        return 1.0f / (sqr(pixelSide_) * cosine * cosine * cosine);
    }
    /// Position on the plane at distance 1 through the middle of the lens. Camera x points to the left of the
    /// image.
    Vec2f planeFromRaster(const Vec2f& raster) const {
        const float w = static_cast<float>(window_.fullWidth), h = static_cast<float>(window_.fullHeight);
        return {((0.5f - offset_.x) * w - raster.x) * pixelSide_,
                ((0.5f - offset_.y) * h - raster.y) * pixelSide_};
    }
    Vec2f rasterFromPlane(const Vec2f& plane) const {
        const float w = static_cast<float>(window_.fullWidth), h = static_cast<float>(window_.fullHeight);
        return {(0.5f - offset_.x) * w - plane.x / pixelSide_, (0.5f - offset_.y) * h - plane.y / pixelSide_};
    }

    Vec3f origin_, x_, y_, z_;
    float nearClip_, lensRadius_, focus_;
    Vec2f offset_;
    float pixelSide_ = 0;  // of a pixel on the plane at distance 1; pixels are square
    float lensPdf_ = 1;
};

}  // namespace

float perspectiveHalfWidth(float fov, FovAxis axis, float aspect) {
    if (!(fov > 0 && fov < 180))
        throw Error("perspective: the field of view must be in (0, 180) degrees, found {}", fov);
    const double ratio = aspect, t = std::tan(0.5 * double(fov) * (std::numbers::pi / 180.0));
    if (axis == FovAxis::Smaller) axis = ratio > 1 ? FovAxis::Y : FovAxis::X;
    if (axis == FovAxis::Larger) axis = ratio > 1 ? FovAxis::X : FovAxis::Y;
    if (axis == FovAxis::Y) return static_cast<float>(t * ratio);
    if (axis == FovAxis::Diagonal) return static_cast<float>(t / std::sqrt(1.0 + 1.0 / (ratio * ratio)));
    return static_cast<float>(t);
}

CameraPtr makePerspectiveCamera(const PerspectiveParameters& parameters, const FilmWindow& window) {
    return std::make_shared<PerspectiveCamera>(parameters, window);
}

}  // namespace metrolux::core
