#pragma once
#include "endpoint/goniometric_light.h"
#include "endpoint/lights.h"
#include "scattering/textures/bitmap_texture.h"
#include "scattering/textures/constant.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace metrolux::core::test {

/// A light with what the tests need to know of it.
struct LightCase {
    std::string name;
    LightPtr light;
    ShapePtr shape = nullptr;  ///< of an area light
    /// Makes the light where that takes a while: every test program lists all cases, few need this one.
    std::function<LightPtr()> later = {};
};

inline const SceneBounds kBounds{Vec3f(0.4f, -0.2f, 0.3f), 3.0f};

inline Transform tilted() {
    return Transform::translate({0.2f, 0.5f, -0.3f}) * Transform::rotate({1, 2, -0.5f}, 67) *
           Transform::rotate({0, 1, 0}, 31);
}

/// Four by three texels, some black, one bright; `nearest` makes it piecewise constant.
inline TexturePtr patchyTexture(bool nearest) {
    BitmapTextureParameters p;
    p.width = 4;
    p.height = 3;
    std::vector<float> pixels;
    for (const float v : {0.1f, 0.0f, 2.0f, 0.3f, 0.0f, 0.0f, 0.5f, 9.0f, 1.0f, 0.2f, 0.0f, 0.7f}) {
        pixels.push_back(v);
        pixels.push_back(0.5f * v);
        pixels.push_back(0.2f * v);
    }
    p.pixels = std::make_shared<const std::vector<float>>(pixels);
    p.filter = nearest ? BitmapTextureParameters::Filter::Nearest : BitmapTextureParameters::Filter::Bilinear;
    p.wrapU = p.wrapV = BitmapTextureParameters::Wrap::Clamp;
    return makeBitmapTexture(p);
}

inline EnvironmentMapParameters patchyEnvironment() {
    EnvironmentMapParameters p;
    p.toWorld = Transform::rotate({1, 1, 0.3f}, 40);
    p.width = 8;
    p.height = 5;
    for (int i = 0; i < 40; ++i) {
        const float v = i % 7 == 0 ? 0.0f : 0.1f * static_cast<float>(i % 5) + (i == 19 ? 12.0f : 0.0f);
        p.pixels.push_back({v, 0.7f * v, 0.3f * v});
    }
    p.scale = 2;
    return p;
}

/// A quarter turn, with angles that are not even, nothing upward and a bright spot.
inline PhotometricWeb patchyWeb() {
    return {{0, 20, 50, 70, 110}, {0, 30, 90}, {1, 2, 0, 1, 0.5f, 1, 9, 1, 0, 0, 1, 3, 2, 0, 1}};
}

/// A tilted sky with a disc of 40 degrees that the horizon cuts, darker toward its limb.
inline SunSkyParameters wideSun() {
    SunSkyParameters p;
    p.up = normalize(Vec3f(0.2f, 1, 0.3f));
    p.sunDirection = normalize(Vec3f(1, 0.1f, 0.2f));
    p.turbidity = 4.3f;
    p.albedo = {0.1f, 0.4f, 0.8f};
    p.skyScale = 20;
    p.sunAperture = 40;
    p.sunProfile = {{9, 8, 7}, {8, 7, 6}, {3, 2, 1}};
    return p;
}
inline SunSkyParameters skyOnly() {
    SunSkyParameters p = wideSun();
    p.sunProfile.clear();
    p.stretch = 1.3f;
    return p;
}
inline SunSkyParameters sunOnly() {
    SunSkyParameters p = wideSun();
    p.skyScale = 0;
    return p;
}

inline LightCase areaCase(const std::string& name, ShapePtr shape, TexturePtr radiance) {
    return {name, makeAreaLight({shape.get(), std::move(radiance)}), shape, {}};
}

inline std::vector<LightCase> allLights() {
    const Transform stretched = tilted() * Transform::scale({0.7f, 0.3f, 1});
    const TexturePtr constant = makeConstantTexture({3, 2, 1});
    std::vector<LightCase> cases = {
        areaCase("rectangle", makeRectangle(stretched, false), constant),
        areaCase("flipped rectangle", makeRectangle(stretched, true), constant),
        areaCase("textured rectangle", makeRectangle(stretched, false), patchyTexture(false)),
        areaCase("mirrored textured rectangle",
                 makeRectangle(stretched * Transform::scale({-1, 1, 1}), false), patchyTexture(true)),
        areaCase("sphere", makeSphere(tilted(), {0, 0, 0}, 0.6f, false), constant),
        areaCase("textured sphere", makeSphere(tilted(), {0, 0, 0}, 0.6f, false), patchyTexture(false)),
        areaCase("sphere from inside", makeSphere(tilted(), {0, 0, 0}, 2.0f, true), constant),
        areaCase("disk", makeDisk(stretched, false), constant),
        areaCase("cylinder", makeCylinder(tilted(), {0, 0, -0.4f}, {0, 0.1f, 0.5f}, 0.3f, false), constant),
        areaCase("cube", makeCube(tilted() * Transform::scale({0.4f, 0.3f, 0.2f}), false), constant),
        {"point", makePointLight({{0.1f, 0.7f, -0.4f}, {4, 3, 2}}), nullptr, {}},
        {"spot", makeSpotLight({tilted(), {4, 3, 2}, 40, 25, nullptr}), nullptr, {}},
        {"textured spot", makeSpotLight({tilted(), {4, 3, 2}, 50, 10, patchyTexture(false)}), nullptr, {}},
        {"wide spot", makeSpotLight({tilted(), {4, 3, 2}, 150, 150, nullptr}), nullptr, {}},
        {"projector", makeProjector({tilted(), patchyTexture(false), 1.5f, 0.6f, 4.0f / 3}), nullptr, {}},
        {"directional", makeDirectionalLight({{0.3f, -2, 0.5f}, {4, 3, 2}}), nullptr, {}},
        {"constant", makeConstantLight({{3, 2, 1}}), nullptr, {}},
        {"environment map", makeEnvironmentMap(patchyEnvironment()), nullptr, {}},
        {"goniometric", makeGoniometricLight({tilted(), {4, 3, 2}, patchyWeb()}), nullptr, {}},
        {"collimated", makeCollimatedLight({tilted(), {4, 3, 2}}), nullptr, {}},
        {"sun and sky", nullptr, nullptr, [] { return makeSunSky(wideSun()); }},
        {"sky", nullptr, nullptr, [] { return makeSunSky(skyOnly()); }},
        {"sun", nullptr, nullptr, [] { return makeSunSky(sunOnly()); }},
    };
    return cases;
}

inline LightCase lightCase(int index) {
    LightCase c = allLights()[static_cast<size_t>(index)];
    if (c.later) c.light = c.later();
    c.light->setSceneBounds(kBounds);
    return c;
}

}  // namespace metrolux::core::test
