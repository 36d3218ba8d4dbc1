#include "io/mitsuba/plugins_sunsky.h"

#include "endpoint/lights.h"
#include "io/mitsuba/field_of_view.h"
#include "io/mitsuba/solar_position.h"
#include "io/mitsuba/sun_spectrum.h"

namespace metrolux::core::mitsuba {

namespace {

constexpr float kSunAperture = 0.5358f;  // degrees, in both Mitsubas
constexpr int kLimbSteps = 33;
constexpr const char* kDateAndPlace[] = {"latitude", "longitude", "timezone", "year",  "month",
                                         "day",      "hour",      "minute",   "second"};

double inRange(const Element& element, const char* name, double value, double low, double high) {
    if (value < low || value > high)
        throw element.error(
            fmt::format("\"{}\" is {}, expected a number from {} to {}", name, value, low, high));
    return value;
}

DateAndPlace readDateAndPlace(const Element& element) {
    DateAndPlace d;
    const auto number = [&](const char* name, double fallback) {
        return element.has(name) ? double(element.number(name, 0)) : fallback;
    };
    d.year = element.integer("year", d.year);
    d.month = element.integer("month", d.month);
    d.day = element.integer("day", d.day);
    d.hour = number("hour", d.hour);
    d.minute = number("minute", d.minute);
    d.second = number("second", d.second);
    d.latitude = number("latitude", d.latitude);
    d.longitude = number("longitude", d.longitude);
    d.timezone = number("timezone", d.timezone);
    inRange(element, "year", double(d.year), -4000, 10000);
    inRange(element, "month", double(d.month), 1, 12);
    inRange(element, "day", double(d.day), 1, 31);
    inRange(element, "latitude", d.latitude, -90, 90);
    return d;
}

/// In the emitter's space. 0.6: +y is up, +x east, -z north. 3.x: +z is up, and what its source does is +x
/// south and -y east (its documentation calls +x north).
Vec3f localDirection(const SolarPosition& sun, bool legacy) {
    const double across = std::sin(sun.zenith), up = std::cos(sun.zenith);
    const double north = std::cos(sun.azimuth) * across, east = std::sin(sun.azimuth) * across;
    const auto vector = [](double x, double y, double z) {
        return Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
    };
    return legacy ? vector(east, up, -north) : vector(-north, -east, up);
}

/// Toward the sun in world space.
Vec3f readSunDirection(const Element& element, const Transform& toWorld) {
    if (!element.has("sun_direction"))
        return toWorld.vector(localDirection(solarPosition(readDateAndPlace(element)), element.isLegacy()));
    for (const char* name : kDateAndPlace)
        if (element.has(name))
            throw element.error(
                fmt::format("found \"sun_direction\" and \"{}\", expected one of them", name));
    return element.vector("sun_direction", Vec3f(0.0f));
}

Rgb readAlbedo(const Element& element, LoadContext& context) {
    const Rgb fallback(element.isLegacy() ? 0.2f : 0.3f);
    const Property* property = element.find("albedo");
    if (property && std::holds_alternative<SpectrumValue>(property->value))
        return textureProperty(element, "albedo", context, fallback)->mean();
    return unboundedColor(element, "albedo", context, fallback);
}

float readScale(const Element& element, const char* name, float fallback) {
    const float scale = element.number(name, fallback);
    if (scale < 0) throw element.error(fmt::format("\"{}\" is {}, expected zero or more", name, scale));
    return scale;
}

/// What differs between the versions: sky, sun, and the sun's size.
struct Scales {
    float sky = 1, sun = 1, aperture = kSunAperture;
    bool limb = false;
};

Scales readScales(const Element& element) {
    Scales s;
    s.sky = readScale(element, "sky_scale", 1);
    s.sun = readScale(element, "sun_scale", 1);
    s.aperture = element.number("sun_aperture", kSunAperture);
    s.limb = element.boolean("complex_sun", false);
    return s;
}

Scales readLegacyScales(const Element& element, LoadContext& context) {
    Scales s;
    const float scale = readScale(element, "scale", 1);
    s.sky = element.type == "sun" ? 0 : scale;
    s.sun = element.type == "sky" ? 0 : scale;
    if (element.type == "sunsky") {
        s.sky = readScale(element, "sky_scale", scale);
        s.sun = readScale(element, "sun_scale", scale);
    }
    if (element.type != "sky") {
        const float radiusScale = element.number("sun_radius_scale", 1);
        if (!(radiusScale >= 0))
            throw element.error(
                fmt::format("\"sun_radius_scale\" is {}, expected a number of zero or more", radiusScale));
        s.aperture *= radiusScale;
        if (radiusScale == 0 && element.type == "sunsky") {
            // A disc in the sky it is, then; its flux does not depend on its size.
            context.warn(element, "a sun without size in a sky has a hundredth of its size here");
            s.aperture = kSunAperture / 100;
        }
    }
    if (element.has("resolution")) {
        element.ignore("resolution");
        context.warn(element, "\"resolution\" has no effect: the sky has a table of its own, the sun none");
    }
    return s;
}

double solidAngle(double aperture) {
    const double sine = std::sin(aperture / 4 * std::numbers::pi / 180);
    return 4 * std::numbers::pi * sine * sine;
}

}  // namespace

LightPtr makeSunSkyLight(const Element& element, LoadContext& context) {
    if (!element.isLegacy() && element.type != "sunsky")
        throw element.error(fmt::format("an emitter of 0.6 only, expected \"sunsky\" with \"{}\" 0",
                                        element.type == "sky" ? "sun_scale" : "sky_scale"));
    const Transform toWorld = element.transform("to_world");
    if (!isSimilarity(toWorld))
        throw element.error(
            "\"to_world\" may rotate, translate, mirror and scale uniformly, found another map");
    SunSkyParameters p;
    p.up = normalize(toWorld.vector(element.isLegacy() ? Vec3f(0, 1, 0) : Vec3f(0, 0, 1)));
    p.sunDirection = readSunDirection(element, toWorld);
    if (!(p.sunDirection.length() > 0)) throw element.error("\"sun_direction\" has no length");
    p.sunDirection = normalize(p.sunDirection);
    p.turbidity = element.number("turbidity", p.turbidity);
    if (!element.isLegacy() || element.type != "sun") p.albedo = readAlbedo(element, context);
    if (element.isLegacy()) p.stretch = element.number("stretch", 1);
    if (element.isLegacy() && element.boolean("extend", false))
        throw element.error(*element.find("extend"),
                            "a sky below the horizon is not supported, expected false");
    const Scales scales = element.isLegacy() ? readLegacyScales(element, context) : readScales(element);
    p.skyScale = scales.sky;
    p.sunAperture = scales.aperture;

    const float zenith = std::acos(std::clamp(dot(p.up, p.sunDirection), -1.0f, 1.0f));
    if (zenith > 0.5f * kPi + 1e-5f) {
        const std::string message =
            fmt::format("the sun is {:.2f} degrees below the horizon", (zenith - 0.5f * kPi) * 180 / kPi);
        if (element.isLegacy()) throw element.error(message + ", which the sky model does not cover");
        context.warn(element, message + ": the emitter is dark and left out, as in Mitsuba 3");
        return nullptr;
    }
    if (scales.sun > 0 && scales.aperture == 0 && element.isLegacy()) {  // a directional light
        const Rgb radiance = sunProfile(std::min(zenith, 0.5f * kPi), p.turbidity, 1).front();
        const auto flux = static_cast<float>(scales.sun * solidAngle(kSunAperture));
        return makeDirectionalLight({-p.sunDirection, radiance * flux});
    }
    if (scales.sun > 0) {
        // The disc's flux does not depend on its size.
        const float scale =
            static_cast<float>(scales.sun * solidAngle(kSunAperture) / solidAngle(scales.aperture));
        p.sunProfile = sunProfile(std::min(zenith, 0.5f * kPi), p.turbidity, scales.limb ? kLimbSteps : 1);
        for (Rgb& c : p.sunProfile) c *= scale;
    }
    return makeSunSky(p);
}

}  // namespace metrolux::core::mitsuba
