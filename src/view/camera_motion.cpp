#include "view/camera_motion.h"

#include "api/internals.h"
#include "io/mitsuba/properties.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace metrolux::core::view {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
/// Smallest angle between the view and the vertical.
constexpr double kLeastFromPole = 2 / kDegrees;

Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator*(double f, const Vector& v) { return {f * v.x, f * v.y, f * v.z}; }
double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector cross(const Vector& a, const Vector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vector normalized(const Vector& v) {
    const double length = std::sqrt(dot(v, v));
    return length > 0 ? (1 / length) * v : v;
}

/// Where an axis of the camera points, or, column 3, where the camera is.
Vector column(const metrolux::Transform& t, size_t c) {
    return {t.rows()[c], t.rows()[4 + c], t.rows()[8 + c]};
}

metrolux::Transform around(const Vector& pivot, const Vector& axis, double radians) {
    using T = metrolux::Transform;
    return T::translate(pivot) * T::rotate(axis, radians * kDegrees) * T::translate(-1 * pivot);
}

}  // namespace

metrolux::Transform cameraOf(const metrolux::Scene& scene) {
    for (const auto& [name, property] : Internals::of(scene).sensor.element->named)
        if (name == "to_world")
            if (const auto* transform = std::get_if<core::Transform>(&property.value))
                return Internals::transform(*transform);
    return {};
}

CameraHandle::CameraHandle(const metrolux::Scene& scene) {
    const Vector up = column(cameraOf(scene), 1);
    const double x = std::abs(up.x), y = std::abs(up.y), z = std::abs(up.z);
    if (y >= x && y >= z)
        up_ = {0, up.y < 0 ? -1.0 : 1.0, 0};
    else if (z >= x)
        up_ = {0, 0, up.z < 0 ? -1.0 : 1.0};
    else
        up_ = {up.x < 0 ? -1.0 : 1.0, 0, 0};
}

/// What the middle of the image shows; where that is nothing, as far away as the middle of the scene.
void CameraHandle::findPivot(const metrolux::Scene& scene) {
    const core::Scene& inside = *Internals::of(scene).scene;
    const FilmWindow& w = inside.camera().window();
    const Vec2f middle(float(w.fullWidth) / 2, float(w.fullHeight) / 2);
    const auto ray = inside.camera().sampleRay({0.5f, 0.5f}, middle);
    if (!ray) return;
    SurfaceInteraction hit;
    float distance = 0;
    if (inside.intersect({ray->origin, ray->direction}, hit))
        distance = (hit.p - ray->origin).length();
    else
        distance = std::max(inside.bounds().radius * 1e-2f,
                            core::dot(inside.bounds().center - ray->origin, ray->direction));
    if (!(distance > 0) || !std::isfinite(distance)) return;
    const Vec3d at = Vec3d(ray->origin + distance * ray->direction) + inside.parts().origin;
    pivot_ = Vector{at.x, at.y, at.z};
    pixelAtPivot_ = double(inside.camera().pixelFootprint(distance));
}

metrolux::Transform CameraHandle::moved(const metrolux::Scene& scene, const CameraMotion& motion) {
    using T = metrolux::Transform;
    if (motion.begins || !pivot_) findPivot(scene);
    T camera = cameraOf(scene);
    if (!pivot_) return camera;
    // image.
    if (motion.yaw != 0) camera = around(*pivot_, up_, motion.yaw) * camera;
    if (motion.pitch != 0) {
        const double angle = std::acos(std::clamp(dot(normalized(column(camera, 2)), up_), -1.0, 1.0));
        const double wanted = std::clamp(angle - motion.pitch, std::min(angle, kLeastFromPole),
                                         std::max(angle, std::numbers::pi - kLeastFromPole));
        // Not the camera's own x axis: a camera may be mirrored.
        const Vector left = normalized(cross(column(camera, 1), column(camera, 2)));
        camera = around(*pivot_, left, wanted - angle) * camera;
    }
    const Vector eye = column(camera, 3);
    camera = T::translate((1 - motion.dolly) * (*pivot_ - eye)) * camera;
    const double width = pixelAtPivot_ * scene.resolution().width;
    const Vector right = (-motion.right * width) * normalized(column(camera, 0)),
                 upward = (motion.up * width) * normalized(column(camera, 1));
    const T shift = T::translate({right.x + upward.x, right.y + upward.y, right.z + upward.z});
    pivot_ = Vector{pivot_->x + right.x + upward.x, pivot_->y + right.y + upward.y,
                    pivot_->z + right.z + upward.z};
    pixelAtPivot_ *= motion.dolly;
    return shift * camera;
}

}  // namespace metrolux::core::view
