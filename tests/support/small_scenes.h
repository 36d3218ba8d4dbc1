#pragma once
/// Scenes made in code for tests of transport: no files, no loader.

#include "endpoint/lights.h"
#include "scattering/dielectric.h"
#include "scattering/diffuse.h"
#include "scattering/rough_conductor.h"
#include "scattering/textures/constant.h"
#include "scene/scene.h"

#include <functional>

namespace metrolux::core::test {

inline TexturePtr constant(const Rgb& value) { return makeConstantTexture(value); }

inline BsdfPtr diffuse(float reflectance) {
    DiffuseParameters p;
    p.reflectance = constant(Rgb(reflectance));
    return makeDiffuse(p);
}

/// Collects the parts of a scene.
class SceneBuilder {
  public:
    ShapePtr add(ShapePtr shape, BsdfPtr bsdf) {
        shape->bsdf = std::move(bsdf);
        parts_.shapes.push_back(shape);
        return shape;
    }
    void emit(const ShapePtr& shape, const Rgb& radiance) { emit(shape, constant(radiance)); }
    void emit(const ShapePtr& shape, TexturePtr radiance) {
        AreaLightParameters p;
        p.shape = shape.get();
        p.radiance = std::move(radiance);
        LightPtr light = makeAreaLight(p);
        shape->emitter = light;
        parts_.lights.push_back(light);
    }
    void light(LightPtr light) { parts_.lights.push_back(std::move(light)); }
    void camera(const Vec3f& origin, const Vec3f& target, float fov, int width, int height) {
        FilmWindow window;
        window.fullWidth = window.width = width;
        window.fullHeight = window.height = height;
        camera(origin, target, fov, window);
    }
    void camera(const Vec3f& origin, const Vec3f& target, float fov, const FilmWindow& window) {
        PerspectiveParameters p;
        p.toWorld = Transform::lookAt(origin, target, Vec3f(0, 1, 0));
        p.fov = fov;
        parts_.camera = makePerspectiveCamera(p, window);
    }
    void camera(CameraPtr camera) { parts_.camera = std::move(camera); }
    void cameraInMedium(MediumIndex medium) { parts_.camera->medium = medium; }
    PathLimits& limits() { return parts_.limits; }
    std::vector<MediumPtr>& media() { return parts_.media; }
    std::shared_ptr<Scene> build() { return std::make_shared<Scene>(std::move(parts_)); }

  private:
    SceneParts parts_;
};

/// A rectangle of half-size (a, b) at `center` whose normal points along `normal`.
inline ShapePtr rectangle(const Vec3f& center, const Vec3f& normal, float a, float b) {
    const Frame f = Frame::fromNormal(normalize(normal));
    const double rows[4][4] = {{f.s.x * a, f.t.x * b, f.n.x, center.x},
                               {f.s.y * a, f.t.y * b, f.n.y, center.y},
                               {f.s.z * a, f.t.z * b, f.n.z, center.z},
                               {0, 0, 0, 1}};
    return makeRectangle(Transform::fromRows(rows), false);
}

}  // namespace metrolux::core::test
