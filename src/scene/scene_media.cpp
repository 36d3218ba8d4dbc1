/// What the endpoints of paths stand in.

#include "media/medium_point.h"
#include "scattering/without_null.h"
#include "scene/scene.h"

namespace metrolux::core {

/// In a scene with media light passes null lobes without an event, and the surfaces that have them scatter
/// the rest. Lamps are met whatever they let pass.
void Scene::fillWithMedia() {
    if (!hasMedia()) return;
    for (const MediumPtr& medium : parts_.media) mediumPoints_.push_back(makeMediumPoint(medium));
    const auto prepare = [](const ShapePtr& shape) {
        if (!shape->emitter) shape->bsdf = withoutNull(shape->bsdf);
    };
    for (const ShapePtr& shape : parts_.shapes) prepare(shape);
    for (const Instance& instance : parts_.instances)
        for (const ShapePtr& shape : instance.group->shapes) prepare(shape);
}

/// What a ray finds on its side of the first boundary that it meets.
std::optional<MediumIndex> Scene::mediumSeen(const Vec3f& p, const Vec3f& direction) const {
    constexpr int kMostCrossings = 1000;
    Ray ray{p, direction, kInfinity};
    SurfaceInteraction si;
    for (int i = 0; i < kMostCrossings && intersect(ray, si); ++i) {
        if (si.shape->media) return mediumBeyond(si, -direction, 0);
        ray.origin = offsetRayOrigin(si.p, si.ng, direction);
    }
    return std::nullopt;
}

/// Of a point for which nothing is declared: boundaries are closed as a rule, so that any direction tells.
/// Where they are not, as a surface of water without walls, some miss them.
MediumIndex Scene::mediumAt(const Vec3f& p) const {
    // No axis, because scenes are made of planes along them.
    static const Vec3f kDirections[] = {{0.48f, 0.36f, 0.8f},   {-0.36f, -0.8f, 0.48f},
                                        {0.6f, -0.64f, -0.48f}, {-0.8f, 0.48f, -0.36f},
                                        {0.36f, -0.48f, 0.8f},  {-0.48f, 0.8f, 0.36f}};
    for (const Vec3f& direction : kDirections)
        if (const auto seen = mediumSeen(p, normalize(direction))) return *seen;
    return outerMedium_;
}

void Scene::findMedia() {
    if (!hasMedia()) return;
    // Around everything is what lies outside the outermost boundary; without any, what the camera stands in.
    const Vec3f inward = normalize(Vec3f(0.36f, -0.48f, 0.8f));
    const auto seen = mediumSeen(bounds_.center - inward * (2 * bounds_.radius), inward);
    outerMedium_ = seen ? *seen : parts_.camera->medium.value_or(0);
    cameraMedium_ = parts_.camera->medium ? *parts_.camera->medium : mediumAt(parts_.camera->position());
    lightMedia_.clear();
    for (const LightPtr& light : parts_.lights) {
        MediumIndex medium = outerMedium_;
        if (light->medium) {
            medium = *light->medium;
        } else if (!light->isInfinite()) {
            if (const auto point = light->sampleRay(Vec2f(0.5f), Vec2f(0.5f)))
                medium = mediumAt(point->origin + point->direction * (1e-4f * bounds_.radius));
        }
        lightMedia_.push_back(medium);
    }
}

MediumIndex Scene::mediumOf(const Light& light, const EndpointRay& point) const {
    if (const Shape* shape = light.shape(); shape && shape->media)
        return dot(point.direction, point.ng) > 0 ? shape->media->exterior : shape->media->interior;
    return lightMedia_[lightIndex_.at(&light)];
}

}  // namespace metrolux::core
