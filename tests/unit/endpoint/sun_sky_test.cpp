/// Sun and sky: the model's values against other people's, the table against the model, the sun's disc, and
/// integrators that agree under them. (What all lights have in common is tested in lights_test.cpp.)

#include "base/error.h"
#include "chi_square.h"
#include "endpoint/lights/hosek_sky.h"
#include "image/film.h"
#include "integrators/registry.h"
#include "light_cases.h"
#include "support/small_scenes.h"

namespace metrolux::core {
namespace {

using test::expectClose;

/// Lumens per unit of our luminance: 683 lm/W times the integral of the observer's Y that radiance is divided
/// by.
constexpr double kLumens = 683 * 106.7502593994140625;

double degrees(double x) { return x * std::numbers::pi / 180; }

TEST(HosekSky, luminanceIsThatOfOtherClearSkies) {
    // Karayel et al. 1984 for a clear zenith, kcd/m^2: (1.376 T - 1.81) tan(elevation) + 0.38 with Linke's
    // turbidity; models of the zenith differ by tens of percent.
    const HosekSky sky(3, Rgb(0.2f), static_cast<float>(degrees(45)));
    const double zenith = luminance(sky.radiance(1, degrees(45))) * kLumens / 1000;
    EXPECT_NEAR(zenith, 1.376 * 3 - 1.81 + 0.38, 0.35 * 2.7);
    // A clear sky's own illuminance on the ground is 10 to 20 thousand lux.
    double illuminance = 0;
    const int n = 200;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const double cos2 = (i + 0.5) / n, cosine = std::sqrt(cos2), sine = std::sqrt(1 - cos2);
            const double cosGamma =
                (cosine + sine * std::cos(2 * std::numbers::pi * (j + 0.5) / n)) * std::sqrt(0.5);
            illuminance += luminance(sky.radiance(cosine, std::acos(std::min(cosGamma, 1.0))));
        }
    illuminance *= std::numbers::pi / (n * n) * kLumens;
    EXPECT_GT(illuminance, 8000);
    EXPECT_LT(illuminance, 20000);
}

TEST(HosekSky, shapeOfAClearSky) {
    const float elevation = static_cast<float>(degrees(40));
    const HosekSky clear(2, Rgb(0.1f), elevation), hazy(8, Rgb(0.1f), elevation),
        snow(2, Rgb(0.9f), elevation);
    const Rgb away = clear.radiance(std::cos(degrees(50)), degrees(100));
    EXPECT_GT(away.z, 2 * away.x) << "blue";
    EXPECT_GT(luminance(clear.radiance(std::cos(degrees(50)), 0.02)), 2 * luminance(away))
        << "bright near the sun";
    EXPECT_GT(luminance(clear.radiance(std::cos(degrees(85)), degrees(100))), luminance(away))
        << "and the horizon";
    const Rgb whiter = hazy.radiance(std::cos(degrees(50)), degrees(100));
    EXPECT_LT(whiter.z / whiter.x, 0.8f * away.z / away.x) << "haze is whiter";
    EXPECT_GT(luminance(snow.radiance(std::cos(degrees(50)), degrees(100))), luminance(away))
        << "snow lights the air";
}

TEST(HosekSky, interpolatesBetweenItsData) {
    const auto at = [](float turbidity, const Rgb& albedo) {
        return HosekSky(turbidity, albedo, 0.6f).radiance(0.5, 0.8);
    };
    EXPECT_GT(at(10, Rgb(1.0f)).x, 0);
    for (const float t : {2.0f, 5.0f, 9.0f})  // continuous
        expectClose(at(t - 1e-4f, Rgb(0.5f)), at(t + 1e-4f, Rgb(0.5f)), 1e-3, "turbidity");
    // Channels take their own albedo.
    const Rgb mixed = at(3, {0, 0.5f, 1});
    EXPECT_EQ(mixed.x, at(3, Rgb(0.0f)).x);
    EXPECT_EQ(mixed.y, at(3, Rgb(0.5f)).y);
    EXPECT_EQ(mixed.z, at(3, Rgb(1.0f)).z);
    EXPECT_THROW(HosekSky(0.9f, Rgb(0.5f), 0.6f), Error);
    EXPECT_THROW(HosekSky(10.1f, Rgb(0.5f), 0.6f), Error);
    EXPECT_THROW(HosekSky(3, {0, 1.1f, 0}, 0.6f), Error);
    EXPECT_THROW(HosekSky(3, {0, -0.1f, 0}, 0.6f), Error);
    EXPECT_THROW(HosekSky(3, Rgb(0.5f), -0.1f), Error);
}

TEST(SunSky, tableFollowsTheModel) {
    SunSkyParameters p;
    p.up = normalize(Vec3f(0.2f, 1, 0.3f));
    const Frame axes = Frame::fromNormal(p.up);
    const double sunTheta = degrees(50), sunPhi = 0.7;
    p.sunDirection = axes.toWorld({static_cast<float>(std::sin(sunTheta) * std::cos(sunPhi)),
                                   static_cast<float>(std::sin(sunTheta) * std::sin(sunPhi)),
                                   static_cast<float>(std::cos(sunTheta))});
    p.turbidity = 2.5f;
    p.skyScale = 2;
    const LightPtr light = makeSunSky(p);
    const HosekSky sky(p.turbidity, p.albedo, static_cast<float>(std::numbers::pi / 2 - sunTheta));
    CounterRng rng(hashKey(4, 5));
    test::Mean error;
    for (int i = 0; i < 20000; ++i) {
        const Vec2f u = rng.next2D();
        const double z = u.x, r = std::sqrt(1 - z * z), phi = 2 * std::numbers::pi * u.y;
        const Vec3f w =
            normalize(axes.toWorld({static_cast<float>(r * std::cos(phi)),
                                    static_cast<float>(r * std::sin(phi)), static_cast<float>(z)}));
        const double gamma = std::acos(std::clamp(double(dot(w, p.sunDirection)), -1.0, 1.0));
        const Rgb expected = sky.radiance(z, gamma) * 2, found = light->environmentRadiance(w);
        for (int k = 0; k < 3; ++k) error.add(std::abs(found[k] - expected[k]) / expected[k]);
        EXPECT_LT(std::abs(luminance(found) - luminance(expected)), 0.05 * luminance(expected)) << z;
    }
    EXPECT_LT(error.value(), 2e-3);
    EXPECT_EQ(light->environmentRadiance(normalize(axes.toWorld({1, 0, -1e-4f}))), Rgb(0.0f))
        << "a black ground";
    EXPECT_GT(light->environmentRadiance(normalize(axes.toWorld({1, 0, 1e-4f}))).x, 0) << "a sharp horizon";
}

TEST(SunSky, stretchMovesTheHorizonAndTheSun) {
    SunSkyParameters p;
    p.sunDirection = {std::sin(1.0f), 0, std::cos(1.0f)};
    p.sunProfile = {Rgb(1000.0f)};
    const LightPtr plain = makeSunSky(p);
    p.stretch = 1.2f;
    const LightPtr stretched = makeSunSky(p);
    const auto at = [](float theta, float phi) {
        return Vec3f(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    };
    EXPECT_GT(plain->environmentRadiance(at(1.0f, 0)).x, 1000);
    EXPECT_LT(stretched->environmentRadiance(at(1.0f, 0)).x, 1000);
    EXPECT_GT(stretched->environmentRadiance(at(1.2f, 0)).x, 1000);
    for (const float theta : {0.1f, 0.8f, 1.4f})
        expectClose(stretched->environmentRadiance(at(1.2f * theta, 2)),
                    plain->environmentRadiance(at(theta, 2)), 3e-3, "sky");
    EXPECT_GT(stretched->environmentRadiance(at(0.5f * kPi * 1.199f, 2)).x, 0);
    EXPECT_EQ(stretched->environmentRadiance(at(0.5f * kPi * 1.201f, 2)), Rgb(0.0f));
    p.stretch = 2;
    EXPECT_GT(makeSunSky(p)->environmentRadiance(normalize(Vec3f(1e-3f, 0, -1))).x, 0);
}

TEST(SunSky, irradianceOfTheSunIsRadianceTimesSolidAngle) {
    for (const float aperture : {0.05f, 0.5358f, 20.0f}) {
        SunSkyParameters p;
        p.skyScale = 0;
        p.sunDirection = normalize(Vec3f(0.3f, 0.4f, 0.8f));
        p.sunAperture = aperture;
        p.sunProfile = {{300, 200, 100}};
        const double solidAngle = 4 * std::numbers::pi * sqr(std::sin(degrees(aperture) / 4));
        const LightPtr light = makeSunSky(p);
        light->setSceneBounds({Vec3f(0.0f), 1});
        EXPECT_NEAR(light->power() / (luminance({300, 200, 100}) * solidAngle * kPi), 1, 1e-4);
        CounterRng rng(hashKey(8, 9));
        test::Mean irradiance;
        const int n = 20000;
        for (int i = 0; i < n; ++i) {
            const auto c = light->connect({0, 0, 0}, rng.next2D());
            irradiance.add(c ? c->value.x / (300 * solidAngle) : 0);
        }
        EXPECT_NEAR(irradiance.value(), 1, 3e-4) << "rounding loses a rim of the disc at most";
        // The edge is where it should be.
        const Frame f = Frame::fromNormal(p.sunDirection);
        const auto seen = [&](double part) {
            const double a = degrees(aperture) / 2 * part;
            return light
                ->environmentRadiance(
                    normalize(f.s * static_cast<float>(std::sin(a)) + f.n * static_cast<float>(std::cos(a))))
                .x;
        };
        EXPECT_EQ(seen(0), 300);
        EXPECT_EQ(seen(0.999), 300);
        EXPECT_EQ(seen(1.001), 0);
    }
    // A profile is linear in the share of the area.
    SunSkyParameters p;
    p.skyScale = 0;
    p.sunProfile = {Rgb(4.0f), Rgb(0.0f)};
    const LightPtr light = makeSunSky(p);
    light->setSceneBounds({Vec3f(0.0f), 1});
    const float a = radians(p.sunAperture) / 2;
    EXPECT_NEAR(light->environmentRadiance({std::sin(a * 0.5f), 0, std::cos(a * 0.5f)}).x, 3, 1e-3);
    EXPECT_NEAR(light->power() / (2 * 4 * kPi * sqr(std::sin(a / 2)) * kPi), 1, 2e-3);
}

TEST(SunSky, theHorizonCutsTheDisc) {
    SunSkyParameters p;
    p.skyScale = 0;
    p.sunDirection = {1, 0, 0};
    p.sunProfile = {Rgb(1.0f)};
    const LightPtr rising = makeSunSky(p);
    p.sunDirection = {0, 0, 1};
    const LightPtr whole = makeSunSky(p);
    EXPECT_NEAR(rising->power() / whole->power(), 0.5, 1e-3);
    EXPECT_EQ(rising->environmentRadiance(normalize(Vec3f(1, 0, -1e-4f))), Rgb(0.0f));
    EXPECT_EQ(rising->environmentRadiance(normalize(Vec3f(1, 0, 1e-4f))), Rgb(1.0f));
}

TEST(SunSky, rejectsWhatMakesNoSense) {
    const auto with = [](auto&& change) {
        SunSkyParameters p;
        p.sunProfile = {Rgb(1.0f)};
        change(p);
        return p;
    };
    EXPECT_NO_THROW(makeSunSky(with([](auto&) {})));
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.turbidity = 11; })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.turbidity = 0.5f, p.skyScale = 0; })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.albedo = Rgb(1.5f); })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.sunDirection = {1, 0, -0.1f}; })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.sunDirection = Vec3f(0.0f); })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.up = Vec3f(0.0f); })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.sunAperture = 0; })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.sunAperture = 90; })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.skyScale = -1; })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.stretch = 0.9f; })), Error);
    EXPECT_THROW(makeSunSky(with([](auto& p) { p.sunProfile = {Rgb(-1.0f)}; })), Error);
}

/// A block on a floor in the sun: the integrators' images agree, and the open floor has the irradiance that
/// the light's own quadrature gives. Both sides of a comparison are means of independent passes.
TEST(SunSky, integratorsAgree) {
    SunSkyParameters sun;
    sun.up = {0, 1, 0};
    sun.sunDirection = normalize(Vec3f(0.5f, 0.8f, 0.3f));
    sun.sunProfile = {Rgb(15000.0f)};
    test::SceneBuilder builder;
    builder.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 3, 3), test::diffuse(0.5f));
    builder.add(makeSphere(Transform::translate({0, 1, 0}), Vec3f(0.0f), 0.6f, false), test::diffuse(0.7f));
    builder.light(makeSunSky(sun));
    builder.camera({0, 3, -6}, {0, 0.5f, 0}, 40, 8, 8);
    builder.limits().maxDepth = 4;
    const std::shared_ptr<Scene> scene = builder.build();
    struct Estimate {
        std::vector<test::Mean> cells = std::vector<test::Mean>(5);  // quarters and the whole image
    };
    const auto render = [&](const char* name, int passes) {
        Estimate e;
        for (int run = 0; run < 24; ++run) {
            CommonOptions options;
            options.seed = static_cast<uint64_t>(run + 1);
            options.limits = scene->parts().limits;
            Film film(scene->camera().window(), ReconstructionFilter(ReconstructionFilter::Kind::Box, {}));
            const auto integrator = makeIntegrator(name, *scene, options);
            for (int i = 0; i < passes; ++i) integrator->renderPass(film, film.passes());
            const std::vector<float> image = film.image();
            double sums[5] = {};
            for (size_t pixel = 0; pixel < 64; ++pixel) {
                const double value =
                    luminance({image[3 * pixel], image[3 * pixel + 1], image[3 * pixel + 2]});
                sums[(pixel / 32) * 2 + (pixel % 8) / 4] += value;
                sums[4] += value;
            }
            for (size_t i = 0; i < 5; ++i) e.cells[i].add(sums[i]);
        }
        return e;
    };
    const Estimate path = render("path", 64);
    for (const char* name : {"vcm", "bdpt"}) {
        const Estimate other = render(name, 32);
        for (size_t i = 0; i < 5; ++i) {
            const double error = std::hypot(path.cells[i].error(), other.cells[i].error());
            EXPECT_NEAR(other.cells[i].value(), path.cells[i].value(),
                        5 * error + 2e-3 * path.cells[i].value())
                << name << " " << i;
            EXPECT_LT(error, 0.02 * path.cells[i].value()) << name;
        }
    }
}

}  // namespace
}  // namespace metrolux::core
