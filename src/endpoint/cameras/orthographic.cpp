#include "base/error.h"
#include "endpoint/camera.h"

namespace metrolux::core {

namespace {

/// All rays are parallel. The film is the window of the plane z = 0 of camera space, seen under the map.
class OrthographicCamera final : public Camera {
  public:
    OrthographicCamera(const OrthographicParameters& p, const FilmWindow& window)
        : Camera(window),
          toWorld_(p.toWorld),
          toCamera_(p.toWorld.inverse()),
          axis_(p.toWorld.vector({0, 0, 1})),
          direction_(normalize(axis_)),
          nearClip_(p.nearClip) {
        requireFilm(window, "orthographic");
        if (!(nearClip_ >= 0)) throw Error("orthographic camera: near clip {} is negative", nearClip_);
        side_ = 2.0f / static_cast<float>(window.fullWidth);
        // Area of a pixel perpendicular to the rays: the map may shear.
        pixelArea_ =
            absDot(cross(p.toWorld.vector({side_, 0, 0}), p.toWorld.vector({0, side_, 0})), direction_);
        if (!(pixelArea_ > 0)) throw Error("orthographic camera: the film has no area under its transform");
    }

    std::optional<EndpointRay> sampleRay(const Vec2f&, const Vec2f& raster) const override {
        const float w = static_cast<float>(window_.fullWidth), h = static_cast<float>(window_.fullHeight);
        EndpointRay ray;
        ray.origin =
            toWorld_.point({(0.5f * w - raster.x) * side_, (0.5f * h - raster.y) * side_, nearClip_});
        ray.direction = direction_;
        ray.weight = Rgb(1.0f);
        ray.pdfPosition = pdfPosition();
        return ray;
    }

    std::optional<EndpointConnection> connect(const Vec3f& x, const Vec2f&) const override {
        const Vec3f local = toCamera_.point(x);
        if (!(local.z > nearClip_)) return std::nullopt;
        const float w = static_cast<float>(window_.fullWidth), h = static_cast<float>(window_.fullHeight);
        EndpointConnection c;
        c.filmPosition = {0.5f * w - local.x / side_, 0.5f * h - local.y / side_};
        if (!(c.filmPosition.x >= 0 && c.filmPosition.x < w && c.filmPosition.y >= 0 && c.filmPosition.y < h))
            return std::nullopt;
        c.wi = -direction_;
        c.point = toWorld_.point({local.x, local.y, nearClip_});
        c.distance = local.z * axis_.length();
        c.value = Rgb(1.0f / pixelArea_);
        c.pdfPosition = pdfPosition();
        return c;
    }

    bool isInfinite() const override { return true; }
    float pixelFootprint(float) const override { return std::sqrt(pixelArea_); }
    Vec3f position() const override { return toWorld_.point(Vec3f(0.0f)); }
    std::optional<Matrices> matrices() const override {
        const Vec3f origin = position();
        const auto local = [&](int axis, float scale, float constant) {
            Row row;
            for (int i = 0; i < 3; ++i) row.axis[i] = static_cast<float>(toCamera_.at(axis, i)) * scale;
            row.constant = constant - dot(row.axis, origin);
            return row;
        };
        const float aspect = static_cast<float>(window_.fullWidth) / static_cast<float>(window_.fullHeight);
        const Row one{Vec3f(0.0f), 1}, forward = local(2, 1, 0);
        return Matrices{matrixOf(local(0, -1, 0), local(1, 1, 0), forward, one),
                        matrixOf(local(0, -0.5f, 0.5f), local(1, -0.5f * aspect, 0.5f), forward, one)};
    }

  private:
    float pdfPosition() const { return 1.0f / (pixelArea_ * static_cast<float>(window_.pixelCount())); }

    Transform toWorld_, toCamera_;
    Vec3f axis_, direction_;
    float nearClip_;
    float side_ = 0;       // of a pixel in camera space
    float pixelArea_ = 0;  // in world space, perpendicular to the rays
};

}  // namespace

CameraPtr makeOrthographicCamera(const OrthographicParameters& parameters, const FilmWindow& window) {
    return std::make_shared<OrthographicCamera>(parameters, window);
}

}  // namespace metrolux::core
