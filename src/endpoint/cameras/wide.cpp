#include "base/error.h"
#include "endpoint/wide_cameras.h"

namespace metrolux::core {

namespace {

/// Sines below are taken for this: directions at a pole have no more than a huge density.
constexpr float kSmallestSine = 1e-6f;

/// All rays pass through one point, and each direction within the view has one raster position.
class WideCamera : public Camera {
  public:
    WideCamera(const WideCameraParameters& p, const FilmWindow& window, const char* name)
        : Camera(window),
          origin_(p.toWorld.point(Vec3f(0.0f))),
          x_(normalize(p.toWorld.vector({1, 0, 0}))),
          y_(normalize(p.toWorld.vector({0, 1, 0}))),
          z_(normalize(p.toWorld.vector({0, 0, 1}))),
          nearClip_(p.nearClip),
          width_(static_cast<float>(window.fullWidth)),
          height_(static_cast<float>(window.fullHeight)) {
        requireFilm(window, name);
        if (!(nearClip_ >= 0)) throw Error("{} camera: near clip {} is negative", name, nearClip_);
    }

    std::optional<EndpointRay> sampleRay(const Vec2f&, const Vec2f& raster) const override {
        const std::optional<Vec3f> local = directionAt(raster);
        if (!local) return std::nullopt;
        EndpointRay ray;
        ray.direction = normalize(x_ * local->x + y_ * local->y + z_ * local->z);
        ray.origin = origin_ + ray.direction * nearClip_;
        ray.weight = Rgb(1.0f);
        ray.pdfDirection = rasterPerSolidAngle(*local) / static_cast<float>(window_.pixelCount());
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f&) const override {
        const Vec3f d = x - origin_;
        EndpointConnection c;
        c.distance = d.length();
        if (!(c.distance > nearClip_)) return std::nullopt;
        c.wi = d * (-1 / c.distance);
        const Vec3f local(-dot(c.wi, x_), -dot(c.wi, y_), -dot(c.wi, z_));
        const std::optional<Vec2f> raster = rasterOf(local);
        if (!raster) return std::nullopt;
        c.filmPosition = *raster;
        c.point = origin_ - c.wi * nearClip_;
        const float importance = rasterPerSolidAngle(local);
        c.value = Rgb(importance / sqr(c.distance));
        c.pdfDirection = importance / static_cast<float>(window_.pixelCount());
        return c;
    }

    Vec3f position() const override { return origin_; }
    Vec3f projectionCenter(const Vec3f& origin, const Vec3f& direction) const override {
        return origin - direction * nearClip_;
    }

  protected:
    // Unit directions in camera space. Nothing outside of the view.
    virtual std::optional<Vec3f> directionAt(const Vec2f& raster) const = 0;
    virtual std::optional<Vec2f> rasterOf(const Vec3f& direction) const = 0;
    /// d(raster area) / d(solid angle).
    virtual float rasterPerSolidAngle(const Vec3f& direction) const = 0;

    Vec3f origin_, x_, y_, z_;
    float nearClip_, width_, height_;
};

class PanoramaCamera final : public WideCamera {
  public:
    PanoramaCamera(const WideCameraParameters& p, const FilmWindow& window)
        : WideCamera(p, window, "panorama") {}

    /// Mean over all directions.
    float pixelFootprint(float distance) const override {
        return distance * std::sqrt(4 * kPi / (width_ * height_));
    }

  private:
    static float sine(const Vec3f& d) { return std::sqrt(d.x * d.x + d.z * d.z); }

    std::optional<Vec3f> directionAt(const Vec2f& raster) const override {
        const float phi = 2 * kPi * raster.x / width_, theta = kPi * raster.y / height_;
        return Vec3f(std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta));
    }
    std::optional<Vec2f> rasterOf(const Vec3f& d) const override {
        float turn = std::atan2(d.x, -d.z) * (0.5f * kInvPi);
        turn -= std::floor(turn);
        const float fall = std::atan2(sine(d), d.y) * kInvPi;
        return Vec2f(std::min(turn, kOneMinusEpsilon) * width_, std::min(fall, kOneMinusEpsilon) * height_);
    }
    float rasterPerSolidAngle(const Vec3f& d) const override {
        return width_ * height_ / (2 * kPi * kPi * std::max(sine(d), kSmallestSine));
    }
};

class FisheyeCamera final : public WideCamera {
  public:
    FisheyeCamera(const WideCameraParameters& p, float aperture, const FilmWindow& window)
        : WideCamera(p, window, "fisheye"), limit_(radians(aperture / 2)) {
        if (!(aperture > 0 && aperture <= 360))
            throw Error("fisheye camera: the aperture must be in (0, 360] degrees, found {}", aperture);
        pixelsPerRadian_ = 0.5f * std::min(width_, height_) / limit_;
    }

    /// In the middle of the image.
    float pixelFootprint(float distance) const override { return distance / pixelsPerRadian_; }

  private:
    std::optional<Vec3f> directionAt(const Vec2f& raster) const override {
        const Vec2f d((0.5f * width_ - raster.x) / pixelsPerRadian_,
                      (0.5f * height_ - raster.y) / pixelsPerRadian_);
        const float theta = d.length();
        if (!(theta < limit_)) return std::nullopt;
        const float factor = theta > 0 ? std::sin(theta) / theta : 1;
        return Vec3f(d.x * factor, d.y * factor, std::cos(theta));
    }
    std::optional<Vec2f> rasterOf(const Vec3f& d) const override {
        const float sine = std::sqrt(d.x * d.x + d.y * d.y), theta = std::atan2(sine, d.z);
        if (!(theta < limit_)) return std::nullopt;
        const float factor = pixelsPerRadian_ * (sine > 0 ? theta / sine : 1);
        const Vec2f raster(0.5f * width_ - d.x * factor, 0.5f * height_ - d.y * factor);
        if (!(raster.x >= 0 && raster.x < width_ && raster.y >= 0 && raster.y < height_)) return std::nullopt;
        return raster;
    }
    float rasterPerSolidAngle(const Vec3f& d) const override {
        const float sine = std::sqrt(d.x * d.x + d.y * d.y), theta = std::atan2(sine, d.z);
        return sqr(pixelsPerRadian_) * (sine > 0 ? theta / std::max(sine, kSmallestSine) : 1);
    }

    float limit_;  ///< angle from the axis
    float pixelsPerRadian_ = 0;
};

}  // namespace

CameraPtr makePanoramaCamera(const WideCameraParameters& parameters, const FilmWindow& window) {
    return std::make_shared<PanoramaCamera>(parameters, window);
}

CameraPtr makeFisheyeCamera(const WideCameraParameters& parameters, float aperture,
                            const FilmWindow& window) {
    return std::make_shared<FisheyeCamera>(parameters, aperture, window);
}

}  // namespace metrolux::core
