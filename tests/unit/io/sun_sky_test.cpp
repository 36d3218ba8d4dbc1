/// `sunsky` of Mitsuba 3, and `sky`, `sun`, `sunsky` of 0.6: parameters, defaults, errors; the sun's position
/// and spectrum against published values.

#include "io/mitsuba/context.h"
#include "io/mitsuba/solar_position.h"
#include "io/mitsuba/spectrum.h"
#include "io/mitsuba/sun_spectrum.h"
#include "support.h"

#include <gmock/gmock.h>

#include <numbers>

namespace metrolux::core {
namespace {

using namespace mitsuba;
using test::errorOf;
using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSunSolidAngle = 6.8681e-5;    // of 0.5358 degrees
constexpr double kLumens = 683 * 106.75025940;  // lm/W times the integral of the observer's Y

LightPtr light(const std::string& body, const std::string& version, LoadContext& context) {
    const ParsedScene scene = test::parseText(test::scene(body, version));
    LightPtr result = makeLight(*scene.root->childrenOf("emitter").at(0), context);
    if (result) result->setSceneBounds({Vec3f(0.0f), 1});
    return result;
}
LightPtr light(const std::string& body, const std::string& version = "3.6.0") {
    LoadContext context;
    LightPtr result = light(body, version, context);
    EXPECT_TRUE(context.warnings.empty()) << context.warnings[0];
    return result;
}
std::string sunsky(const std::string& inside) { return "<emitter type=\"sunsky\">" + inside + "</emitter>"; }
std::string legacy(const std::string& type, const std::string& inside) {
    return "<emitter type=\"" + type + "\">" + inside + "</emitter>";
}
std::string number(const std::string& name, double value) {
    return fmt::format("<float name=\"{}\" value=\"{}\"/>", name, value);
}
std::string direction(const std::string& name, const Vec3f& v) {
    return fmt::format("<vector name=\"{}\" x=\"{}\" y=\"{}\" z=\"{}\"/>", name, v.x, v.y, v.z);
}

/// Radiance all around, in the space in which +z is up; `turn` goes from there to the light's.
void expectSameLight(const Light& a, const Light& b, const std::function<Vec3f(const Vec3f&)>& turn,
                     double tolerance = 1e-5) {
    EXPECT_NEAR(b.power() / a.power(), 1, tolerance);
    for (int i = -19; i < 20; ++i)
        for (int j = 0; j < 40; ++j) {
            const float z = (static_cast<float>(i) + 0.5f) / 20, r = std::sqrt(1 - z * z),
                        phi = 2 * kPi * (static_cast<float>(j) + 0.3f) / 40;
            const Vec3f w(r * std::cos(phi), r * std::sin(phi), z);
            const Rgb x = a.environmentRadiance(w), y = b.environmentRadiance(turn(w));
            for (int k = 0; k < 3; ++k) EXPECT_NEAR(x[k], y[k], tolerance * x[k] + 1e-9) << w.x << " " << w.z;
        }
}
Vec3f same(const Vec3f& w) { return w; }
/// +z up to +y up.
Vec3f yUp(const Vec3f& w) { return {w.x, w.z, -w.y}; }

TEST(SolarPosition, againstTheExampleOfNrel) {
    // Reda & Andreas, Solar Position Algorithm for Solar Radiation Applications (NREL/TP-560-34302), table
    // A5.1: 17 October 2003, 12:30:30, 7 hours behind UT, 39.742476 N, 105.1786 W: elevation 39.872046
    // degrees before refraction, azimuth 194.340241 degrees. The PSA algorithm is good to 0.5 minutes of arc.
    const SolarPosition sun = solarPosition({.year = 2003,
                                             .month = 10,
                                             .day = 17,
                                             .hour = 12,
                                             .minute = 30,
                                             .second = 30,
                                             .latitude = 39.742476,
                                             .longitude = -105.1786,
                                             .timezone = -7});
    EXPECT_NEAR(90 - sun.zenith / kDegree, 39.872046, 0.0084);
    EXPECT_NEAR(sun.azimuth / kDegree, 194.340241, 0.0084 / std::cos(39.87 * kDegree));
}

TEST(SolarPosition, dateAndTimeWrapAround) {
    const SolarPosition a = solarPosition({.hour = 23, .minute = 59, .second = 60});
    const SolarPosition b = solarPosition({.day = 11, .hour = 0});
    EXPECT_NEAR(a.zenith, b.zenith, 1e-9);
    EXPECT_NEAR(a.azimuth, b.azimuth, 1e-9);
    EXPECT_NEAR(solarPosition({.month = 2, .day = 29}).zenith, solarPosition({.month = 3, .day = 1}).zenith,
                1e-12)
        << "2010 is no leap year";
    // The sun stands in the south at noon in Greenwich, about 90 - 51.48 + 23.44 degrees high at midsummer.
    const SolarPosition noon = solarPosition({.year = 2010,
                                              .month = 6,
                                              .day = 21,
                                              .hour = 12.03,
                                              .latitude = 51.48,
                                              .longitude = 0,
                                              .timezone = 0});
    EXPECT_NEAR(90 - noon.zenith / kDegree, 61.96, 0.02);
    EXPECT_NEAR(noon.azimuth / kDegree, 180, 0.3);
}

TEST(SunSpectrum, illuminanceOfDirectSunlight) {
    // Outside the atmosphere 128 to 134 thousand lux; on the ground about 100 thousand under a high sun.
    const auto lux = [](double zenith, double turbidity) {
        return luminance(emissionFromSpectrum(sunSpectrum(zenith * kDegree, turbidity))) * kSunSolidAngle *
               kLumens;
    };
    EXPECT_NEAR(lux(0, 2), 105000, 10000);
    EXPECT_NEAR(lux(60, 2.5), 80000, 10000);
    EXPECT_GT(lux(30, 2), lux(30, 5));
    EXPECT_GT(lux(30, 3), lux(80, 3));
    const Rgb high = emissionFromSpectrum(sunSpectrum(0, 2)),
              low = emissionFromSpectrum(sunSpectrum(88 * kDegree, 2));
    EXPECT_GT(low.x / low.y, 2 * high.x / high.y) << "red in the evening";
    EXPECT_GE(low.z, 0);
}

TEST(SunSpectrum, limbDarkeningKeepsTheMean) {
    const std::vector<Rgb> uniform = sunProfile(0.5, 3, 1), darkened = sunProfile(0.5, 3, 33);
    ASSERT_EQ(uniform.size(), 1u);
    ASSERT_EQ(darkened.size(), 33u);
    Rgb mean(0.0f);
    for (size_t i = 0; i < 33; ++i) mean += darkened[i] * ((i == 0 || i == 32 ? 0.5f : 1.0f) / 32);
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(mean[k] / uniform[0][k], 1, 1e-5);
        EXPECT_GT(darkened[0][k], 1.15f * uniform[0][k]);
        EXPECT_LT(darkened[32][k], 0.6f * uniform[0][k]);
    }
    EXPECT_GT(darkened[32].x / darkened[0].x, darkened[32].z / darkened[0].z) << "the limb is redder";
}

TEST(SunSkyLoader, defaultsAreMitsubas) {
    const LightPtr plain = light(sunsky(""));
    EXPECT_TRUE(plain->isEnvironment());
    const LightPtr spelled =
        light(sunsky(number("turbidity", 3) + "<rgb name=\"albedo\" value=\"0.3\"/>" +
                     number("latitude", 35.6894) + number("longitude", 139.6917) + number("timezone", 9) +
                     "<integer name=\"year\" value=\"2010\"/><integer name=\"month\" value=\"7\"/>"
                     "<integer name=\"day\" value=\"10\"/>" +
                     number("hour", 15) + number("minute", 0) + number("second", 0) + number("sun_scale", 1) +
                     number("sky_scale", 1) + number("sun_aperture", 0.5358) +
                     "<boolean name=\"complex_sun\" value=\"false\"/>"));
    expectSameLight(*plain, *spelled, same, 1e-4);
    // +x is south and -y east: the afternoon's sun is in the west.
    const SolarPosition sun = solarPosition({});
    EXPECT_GT(sun.azimuth / kDegree, 200);
    const double across = std::sin(sun.zenith);
    const Vec3f toward(static_cast<float>(-std::cos(sun.azimuth) * across),
                       static_cast<float>(-std::sin(sun.azimuth) * across),
                       static_cast<float>(std::cos(sun.zenith)));
    EXPECT_GT(toward.y, 0);
    EXPECT_GT(plain->environmentRadiance(toward).x, 1000);
    EXPECT_LT(plain->environmentRadiance(normalize(toward + Vec3f(0, 0.02f, 0))).x, 10);
}

TEST(SunSkyLoader, parametersAct) {
    const std::string sun = direction("sun_direction", {1, 1, 1.5f});
    const Vec3f toward = normalize(Vec3f(1, 1, 1.5f)), away = normalize(Vec3f(-1, 0.3f, 1));
    const LightPtr both = light(sunsky(sun)), sky = light(sunsky(sun + number("sun_scale", 0))),
                   disc = light(sunsky(sun + number("sky_scale", 0)));
    EXPECT_EQ(disc->environmentRadiance(away), Rgb(0.0f));
    EXPECT_GT(sky->environmentRadiance(away).x, 0);
    EXPECT_NEAR(both->power() / (sky->power() + disc->power()), 1, 1e-5);
    const LightPtr bright = light(sunsky(sun + number("sun_scale", 2) + number("sky_scale", 3)));
    EXPECT_NEAR(bright->power() / (3 * sky->power() + 2 * disc->power()), 1, 1e-5);
    // The aperture keeps the sun's irradiance.
    const LightPtr wide = light(sunsky(sun + number("sky_scale", 0) + number("sun_aperture", 5)));
    EXPECT_NEAR(wide->power() / disc->power(), 1, 1e-3);
    EXPECT_LT(wide->environmentRadiance(toward).x, 0.02f * disc->environmentRadiance(toward).x);
    const LightPtr limb =
        light(sunsky(sun + number("sky_scale", 0) + "<boolean name=\"complex_sun\" value=\"true\"/>"));
    EXPECT_NEAR(limb->power() / disc->power(), 1, 1e-3);
    EXPECT_GT(limb->environmentRadiance(toward).x, 1.1f * disc->environmentRadiance(toward).x);
    EXPECT_GT(light(sunsky(sun + number("turbidity", 8)))->environmentRadiance(away).x,
              sky->environmentRadiance(away).x);
    const LightPtr green = light(sunsky(sun + "<rgb name=\"albedo\" value=\"0.3 1 0.3\"/>"));
    EXPECT_EQ(green->environmentRadiance(away).x, sky->environmentRadiance(away).x);
    EXPECT_GT(green->environmentRadiance(away).y, sky->environmentRadiance(away).y);
}

TEST(SunSkyLoader, toWorldTurnsTheZenithAndTheDate) {
    // Rotating by -90 degrees about x takes +z to +y, as scenes with +y up need it.
    const std::string turn = "<transform name=\"to_world\"><rotate x=\"1\" angle=\"-90\"/></transform>";
    expectSameLight(*light(sunsky("")), *light(sunsky(turn)), yUp, 2e-4);
    // A direction is in world space.
    const LightPtr plain = light(sunsky(direction("sun_direction", {0.3f, 0.5f, 0.7f})));
    const LightPtr turned = light(sunsky(turn + direction("sun_direction", yUp({0.3f, 0.5f, 0.7f}))));
    expectSameLight(*plain, *turned, yUp, 2e-4);
}

TEST(SunSkyLoader, legacyTwins) {
    const Vec3f sun(0.2f, -0.4f, 0.6f);
    const std::string old = direction("sunDirection", yUp(sun)) + number("turbidity", 4) +
                            "<rgb name=\"albedo\" value=\"0.5, 0.4, 0.3\"/>";
    const std::string twin = direction("sun_direction", sun) + number("turbidity", 4) +
                             "<rgb name=\"albedo\" value=\"0.5 0.4 0.3\"/>";
    const std::string turn = "<transform name=\"to_world\"><rotate x=\"1\" angle=\"-90\"/></transform>";
    const auto check = [&](const std::string& type, const std::string& more, const std::string& newMore) {
        SCOPED_TRACE(type);
        expectSameLight(*light(sunsky(twin + newMore)), *light(legacy(type, old + more), "0.6.0"), yUp, 2e-4);
        // And exactly so, given the same axes.
        const LightPtr upright =
            light(sunsky(turn + direction("sun_direction", yUp(sun)) + number("turbidity", 4) +
                         "<rgb name=\"albedo\" value=\"0.5 0.4 0.3\"/>" + newMore));
        expectSameLight(*upright, *light(legacy(type, old + more), "0.6.0"), same, 1e-6);
    };
    check("sunsky", "", "");
    check("sunsky", number("scale", 2), number("sun_scale", 2) + number("sky_scale", 2));
    check("sunsky", number("scale", 2) + number("sunScale", 3),
          number("sun_scale", 3) + number("sky_scale", 2));
    check("sunsky", number("skyScale", 4) + number("sunRadiusScale", 10),
          number("sky_scale", 4) + number("sun_aperture", 5.358));
    check("sky", number("scale", 2), number("sky_scale", 2) + number("sun_scale", 0));
    const std::string noAlbedo = direction("sunDirection", yUp(sun)) + number("turbidity", 4);
    expectSameLight(*light(sunsky(twin + number("sun_scale", 2) + number("sky_scale", 0))),
                    *light(legacy("sun", noAlbedo + number("scale", 2)), "0.6.0"), yUp, 2e-4);
    // Defaults: the ground's albedo is 0.2, and the date's sun is placed with +x east and -z north.
    expectSameLight(*light(sunsky(direction("sun_direction", sun) + "<rgb name=\"albedo\" value=\"0.2\"/>")),
                    *light(legacy("sunsky", direction("sunDirection", yUp(sun))), "0.6.0"), yUp, 2e-4);
    const SolarPosition p = solarPosition({});
    const double r = std::sin(p.zenith);
    EXPECT_GT(light(legacy("sun", ""), "0.5.0")
                  ->environmentRadiance({static_cast<float>(std::sin(p.azimuth) * r),
                                         static_cast<float>(std::cos(p.zenith)),
                                         static_cast<float>(-std::cos(p.azimuth) * r)})
                  .x,
              1000);
    // The horizon moves.
    EXPECT_GT(light(legacy("sky", number("stretch", 1.2)), "0.6.0")
                  ->environmentRadiance(normalize(Vec3f(1, -0.1f, 0)))
                  .x,
              0);
    LoadContext context;
    ASSERT_TRUE(light(legacy("sky", "<integer name=\"resolution\" value=\"1024\"/>"), "0.6.0", context));
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_THAT(context.warnings[0], HasSubstr("resolution"));
}

TEST(SunSkyLoader, errorsNameThePlace) {
    const auto error = [](const std::string& body, const std::string& version = "3.6.0") {
        const std::string message = errorOf([&] { light(body, version); });
        EXPECT_THAT(message, HasSubstr("scene.xml:2"));
        return message;
    };
    EXPECT_THAT(error(sunsky(number("turbidity", 0.5))), HasSubstr("turbidity 0.5"));
    EXPECT_THAT(error(sunsky(number("turbidity", 10.5))), HasSubstr("turbidity 10.5"));
    EXPECT_THAT(error(sunsky("<rgb name=\"albedo\" value=\"0.1 1.2 0.3\"/>")), HasSubstr("albedo"));
    EXPECT_THAT(error(sunsky(number("albedo", -0.1))), HasSubstr("albedo"));
    EXPECT_THAT(error(sunsky("<texture name=\"albedo\" type=\"checkerboard\"/>")), HasSubstr("albedo"));
    EXPECT_THAT(error(sunsky(number("sun_scale", -1))), HasSubstr("sun_scale"));
    EXPECT_THAT(error(sunsky(number("sky_scale", -1))), HasSubstr("sky_scale"));
    EXPECT_THAT(error(sunsky(number("sun_aperture", 0))), HasSubstr("aperture"));
    EXPECT_THAT(error(sunsky(number("sun_aperture", 95))), HasSubstr("aperture"));
    EXPECT_THAT(error(sunsky(direction("sun_direction", {0, 0, 0}))), HasSubstr("no length"));
    EXPECT_THAT(error(sunsky(direction("sun_direction", {0, 0, 1}) + number("hour", 3))),
                HasSubstr("\"hour\""));
    EXPECT_THAT(error(sunsky("<integer name=\"month\" value=\"13\"/>")), HasSubstr("1 to 12"));
    EXPECT_THAT(error(sunsky(number("latitude", 100))), HasSubstr("latitude"));
    EXPECT_THAT(error(sunsky(number("turbidty", 3))), HasSubstr("did you mean \"turbidity\""));
    EXPECT_THAT(error(sunsky(number("stretch", 1))), HasSubstr("stretch"));
    EXPECT_THAT(error(sunsky("<transform name=\"to_world\"><scale x=\"1\" y=\"2\" z=\"1\"/></transform>")),
                HasSubstr("scale uniformly"));
    EXPECT_THAT(error("<emitter type=\"sky\"/>"), HasSubstr("\"sunsky\" with \"sun_scale\" 0"));
    EXPECT_THAT(error("<emitter type=\"sun\"/>"), HasSubstr("\"sunsky\" with \"sky_scale\" 0"));
    EXPECT_THAT(error("<emitter type=\"sunsy\"/>"), HasSubstr("\"sunsky\""));
    EXPECT_THAT(error(legacy("sunsky", number("sunRadiusScale", -1)), "0.6.0"), HasSubstr("zero or more"));
    EXPECT_THAT(error(legacy("sky", number("stretch", 3)), "0.6.0"), HasSubstr("1 to 2"));
    EXPECT_THAT(error(legacy("sky", "<boolean name=\"extend\" value=\"true\"/>"), "0.6.0"),
                HasSubstr("extend"));
    EXPECT_THAT(error(legacy("sky", number("hour", 22)), "0.6.0"), HasSubstr("below the horizon"));
}

TEST(SunSkyLoader, whatTheOtherPluginsOf06HaveIsAWarning) {
    for (const std::string& body :
         {legacy("sky", number("sunRadiusScale", 2)), legacy("sun", number("albedo", 0.5))}) {
        LoadContext context;
        EXPECT_TRUE(light(body, "0.6.0", context));
        ASSERT_EQ(context.warnings.size(), 1u);
        EXPECT_THAT(context.warnings[0], HasSubstr("not used"));
    }
}

TEST(SunSkyLoader, nightLeavesTheEmitterOut) {
    LoadContext context;
    EXPECT_EQ(light(sunsky(number("hour", 22)), "3.6.0", context), nullptr);
    ASSERT_EQ(context.warnings.size(), 1u);
    EXPECT_THAT(context.warnings[0], HasSubstr("below the horizon"));
}

}  // namespace
}  // namespace metrolux::core
