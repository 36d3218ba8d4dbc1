/// Scenes of any brightness: emission times 2^k gives the image times 2^k.

#include "endpoint/goniometric_light.h"
#include "integrators/registry.h"
#include "scattering/textures/bitmap_texture.h"
#include "support/small_scenes.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

/// 4 x 3 texels, none of them black.
TexturePtr picture(float factor) {
    BitmapTextureParameters p;
    p.width = 4;
    p.height = 3;
    p.channels = 1;
    std::vector<float> pixels{0.25f, 0.9f, 0.4f, 0.6f, 1.0f, 0.3f, 0.7f, 0.5f, 0.8f, 0.4f, 0.6f, 0.4f};
    for (float& pixel : pixels) pixel *= factor;
    p.pixels = std::make_shared<const std::vector<float>>(pixels);
    return makeBitmapTexture(p);
}

void addRoom(SceneBuilder& b) {
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(test::rectangle({0, 2, -2}, {0, 0, 1}, 4, 3), test::diffuse(0.5f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), makeDielectric({}));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 14, 12);
    b.limits().maxDepth = 6;
}

/// Lights of every kind, their emission times 2^k.
std::shared_ptr<Scene> room(int k) {
    const float factor = std::ldexp(1.0f, k);
    const auto above = [](float x) { return Transform::lookAt({x, 3, 1}, {0.3f, 0, 0.3f}, {0, 0, 1}); };
    SceneBuilder b;
    addRoom(b);
    b.emit(b.add(test::rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)),
           Rgb(5 * factor));
    b.emit(b.add(test::rectangle({-1, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)), picture(factor));
    PointLightParameters point;
    point.position = {1, 2, 1};
    point.intensity = Rgb(3 * factor);
    b.light(makePointLight(point));
    SpotLightParameters spot;
    spot.toWorld = above(1.5f);
    spot.intensity = Rgb(8 * factor);
    spot.cutoffAngle = 50;
    spot.beamWidth = 30;
    b.light(makeSpotLight(spot));
    ProjectorParameters projector;
    projector.toWorld = above(-1);
    projector.irradiance = picture(1);
    projector.tanHalfFovX = 0.8f;
    projector.aspect = 1.4f;
    projector.scale = 3 * factor;
    b.light(makeProjector(projector));
    CollimatedLightParameters beam;
    beam.toWorld = above(-0.3f);
    beam.power = Rgb(10 * factor);
    b.light(makeCollimatedLight(beam));
    GoniometricLightParameters web;
    web.toWorld = above(0.8f);
    web.scale = Rgb(2 * factor);
    web.web = {{0, 60, 120}, {0}, {1, 3, 0.5f}};
    b.light(makeGoniometricLight(web));
    DirectionalLightParameters directional;
    directional.direction = normalize(Vec3f(0.2f, -1, -0.1f));
    directional.irradiance = Rgb(factor);
    b.light(makeDirectionalLight(directional));
    EnvironmentMapParameters map;
    map.width = 8;
    map.height = 5;
    for (int i = 0; i < map.width * map.height; ++i)
        map.pixels.push_back(Rgb(factor * (0.3f + static_cast<float>(i * 7 % 11))));
    b.light(makeEnvironmentMap(std::move(map)));
    return b.build();
}

std::shared_ptr<Scene> outdoors(int k) {
    const float factor = std::ldexp(1.0f, k);
    SunSkyParameters p;
    p.up = {0, 1, 0};
    p.sunDirection = normalize(Vec3f(0.4f, 1, 0.5f));
    p.sunAperture = 20;
    p.sunProfile = {Rgb(3 * factor), Rgb(factor)};
    p.skyScale = factor;
    SceneBuilder b;
    addRoom(b);
    b.light(makeSunSky(p));
    return b.build();
}

std::shared_ptr<Scene> constantLight(int k) {
    SceneBuilder b;
    addRoom(b);
    b.light(makeConstantLight({Rgb(std::ldexp(1.0f, k))}));
    return b.build();
}

struct Rendering {
    std::vector<float> image, variance;
    double relativeError;
    uint64_t beyondFloat;
};

Rendering render(const Scene& scene, const std::string& name, int passes) {
    CommonOptions options;
    options.seed = 5;
    options.limits = scene.parts().limits;
    const std::unique_ptr<Integrator> integrator = makeIntegrator(name, scene, options);
    Film film = makeFilm(scene);
    for (int i = 0; i < passes; ++i) integrator->renderPass(film, film.passes());
    EXPECT_EQ(integrator->nonFinite(), TechniqueCounts{}) << name;
    return {film.image(), film.variance(), film.relativeError(), film.beyondFloat()};
}

std::vector<float> times(std::vector<float> values, int exponent) {
    for (float& v : values) v = std::ldexp(v, exponent);
    return values;
}

/// To the bit, but for what the film counts as beyond single precision.
void expectMultiples(const Rendering& found, const Rendering& base, int exponent) {
    uint64_t beyond = 0;
    for (size_t i = 0; i < base.image.size(); ++i) {
        const double expected = std::ldexp(double(base.image[i]), exponent);
        const bool inside = expected == 0 || (std::abs(expected) >= std::numeric_limits<float>::min() &&
                                              std::abs(expected) <= std::numeric_limits<float>::max());
        beyond += inside ? 0 : 1;
        if (inside)
            ASSERT_EQ(double(found.image[i]), expected) << "value " << i;
        else
            ASSERT_TRUE(std::isfinite(found.image[i]));
    }
    EXPECT_EQ(found.beyondFloat, beyond);
}

class EmissionScale : public ::testing::TestWithParam<std::string> {};

/// Out of ordinary brightness (2^20 either way) to the bit, from one end to the other.
TEST_P(EmissionScale, ImagesOfBrightAndDarkScenesAreMultiplesToTheBit) {
    constexpr int kPasses = 3;
    for (const auto& make : {room, outdoors, constantLight}) {
        constexpr int kBase = 40;
        const Rendering base = render(*make(kBase), GetParam(), kPasses);
        for (const int k : {-120, -97, -64, -31, 31, 70, 99, 110}) {
            // Textures are interpolated as they were given: below 2^-110 single precision loses bits there.
            if (k < -110 && make == room) continue;
            const Rendering other = render(*make(k), GetParam(), kPasses);
            expectMultiples(other, base, k - kBase);
            if (testing::Test::HasFailure()) FAIL() << "k = " << k;
            EXPECT_EQ(other.relativeError, base.relativeError);
        }
        EXPECT_GT(*std::max_element(base.image.begin(), base.image.end()), 0);
    }
}

/// In between, film sums are rounded to fixed units, and scenes keep the bits of the version before.
TEST_P(EmissionScale, ImagesOfOrdinaryScenesAreMultiplesButForTheRoundingOfSums) {
    const auto scene = room(0), brighter = room(9), bright = room(40);
    EXPECT_EQ(scene->emissionExponent(), 0);
    EXPECT_EQ(brighter->emissionExponent(), 0);
    EXPECT_NE(bright->emissionExponent(), 0);
    const std::vector<float> image = render(*scene, GetParam(), 3).image;
    const double mean = std::accumulate(image.begin(), image.end(), 0.0) / double(image.size());
    for (const auto& [other, k] : {std::pair(brighter, 9), {bright, 40}}) {
        const std::vector<float> scaled = times(render(*other, GetParam(), 3).image, -k);
        // The worst is a term just above 2^12, of which 16 bits are added.
        for (size_t i = 0; i < image.size(); ++i)
            ASSERT_NEAR(scaled[i], image[i], 0x1p-16 * std::max(mean, double(image[i]))) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(All, EmissionScale, ::testing::ValuesIn([] {
                             std::vector<std::string> names;
                             for (const IntegratorDescription& d : integratorList()) names.push_back(d.name);
                             return names;
                         }()),
                         [](const auto& i) { return i.param; });

TEST(EmissionScale, EveryExponentFrom120DownToMinus120) {
    const Rendering base = render(*constantLight(40), "vcm", 1);
    for (int k = -120; k <= 120; ++k) {
        const std::shared_ptr<Scene> scene = constantLight(k);
        EXPECT_EQ(scene->emissionExponent(), std::abs(k) <= 20 ? 0 : k);
        if (std::abs(k) <= 20) continue;
        expectMultiples(render(*scene, "vcm", 1), base, k - 40);
        if (testing::Test::HasFailure()) FAIL() << "k = " << k;
    }
}

TEST(EmissionScale, AViewOfASceneHasItsScaleAndOtherScenesOfTheSameLightsToo) {
    const std::shared_ptr<Scene> scene = room(70);
    const SceneParts& parts = scene->parts();
    const Scene view(*scene, {parts.camera, parts.limits, parts.filterKind, parts.filter});
    EXPECT_EQ(view.emissionExponent(), scene->emissionExponent());
    const Scene again(parts);
    EXPECT_EQ(again.emissionExponent(), scene->emissionExponent());
    EXPECT_EQ(render(again, "path", 1).image, render(*scene, "path", 1).image);
}

TEST(EmissionScale, TheBrightestAndTheFaintestEmissionGiveFiniteImages) {
    for (const float radiance : {3e38f, 1.2e-38f}) {
        SceneBuilder b;
        addRoom(b);
        b.light(makeConstantLight({Rgb(radiance)}));
        const Rendering r = render(*b.build(), "path", 4);
        for (const float v : r.image) ASSERT_TRUE(std::isfinite(v));
        EXPECT_EQ(r.beyondFloat > 0, radiance < 1);
        EXPECT_GT(*std::max_element(r.image.begin(), r.image.end()), 0.5f * radiance);
    }
}

}  // namespace
}  // namespace metrolux::core
