#include "endpoint/goniometric_light.h"
#include "endpoint/lights.h"
#include "image/image_io.h"
#include "io/ies_file.h"
#include "io/mitsuba/context.h"
#include "io/mitsuba/field_of_view.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/plugins_sunsky.h"
#include "io/mitsuba/unknown_plugins.h"

#include <algorithm>

namespace metrolux::core::mitsuba {

namespace {

const std::vector<std::string> kEmitterTypes = {"point",  "spot",      "directional", "constant",
                                                "envmap", "projector", "collimated",  "sunsky",
                                                "sky",    "sun",       "goniometric", "area"};

/// An emission that may not vary in space.
Rgb emissionColor(const Element& element, const std::string& name, LoadContext& context,
                  const Rgb& fallback) {
    const TexturePtr texture = emissionProperty(element, name, context, fallback);
    if (!texture->isConstant()) throw element.error("\"" + name + "\" cannot vary over a texture here");
    return texture->mean();
}

Transform similarity(const Element& element, const LoadContext& context) {
    const Transform toWorld = context.toWorld(element);
    if (!isSimilarity(toWorld))
        throw element.error(
            "\"to_world\" may rotate, translate, mirror and scale uniformly, found another map");
    return toWorld;
}

/// The same for an emitter that is at a place.
Transform placement(const Element& element, const LoadContext& context) {
    const Transform toWorld = similarity(element, context);
    context.place(element, context.origin + toWorld.exactPoint(Vec3d(0.0)));
    return toWorld;
}

LightPtr makePoint(const Element& element, LoadContext& context) {
    PointLightParameters p;
    if (element.has("position") && element.has("to_world"))
        throw element.error("found \"position\" and \"to_world\", expected one of them");
    p.position = context.place(element, element.has("position")
                                            ? element.point("position", Vec3d(0.0))
                                            : element.transform("to_world").exactPoint(Vec3d(0.0)));
    p.intensity = emissionColor(element, "intensity", context, p.intensity);
    return makePointLight(p);
}

LightPtr makeSpot(const Element& element, LoadContext& context) {
    SpotLightParameters p;
    p.toWorld = placement(element, context);
    p.intensity = emissionColor(element, "intensity", context, p.intensity);
    p.cutoffAngle = element.number("cutoff_angle", p.cutoffAngle);
    p.beamWidth = element.number("beam_width", p.cutoffAngle * 0.75f);
    if (p.beamWidth > p.cutoffAngle) {
        context.warn(element, fmt::format("\"beam_width\" {} is cut at \"cutoff_angle\", {}", p.beamWidth,
                                          p.cutoffAngle));
        p.beamWidth = p.cutoffAngle;
    }
    if (element.has("texture")) p.texture = textureProperty(element, "texture", context, Rgb(1.0f));
    return makeSpotLight(p);
}

LightPtr makeDirectional(const Element& element, LoadContext& context) {
    DirectionalLightParameters p;
    if (element.has("direction") && element.has("to_world"))
        throw element.error("found \"direction\" and \"to_world\", expected one of them");
    p.direction = element.has("direction") ? element.vector("direction", p.direction)
                                           : element.transform("to_world").vector(p.direction);
    p.irradiance = emissionColor(element, "irradiance", context, p.irradiance);
    return makeDirectionalLight(p);
}

LightPtr makeConstant(const Element& element, LoadContext& context) {
    return makeConstantLight({emissionColor(element, "radiance", context, Rgb(1.0f))});
}

LightPtr makeEnvmap(const Element& element, LoadContext& context) {
    EnvironmentMapParameters p;
    p.toWorld = similarity(element, context);
    p.scale = element.number("scale", 1);
    element.ignore("mis_compensation");  // a choice of sampling density only
    const ImageData image = context.image(element, false);
    p.width = image.width;
    p.height = image.height;
    p.pixels.reserve(size_t(image.width) * static_cast<size_t>(image.height));
    size_t negative = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const float* v = image.at(x, y);
            Rgb c = image.channels >= 3 ? Rgb(v[0], v[1], v[2]) : Rgb(v[0]);
            if (!isFinite(c))
                throw element.error(fmt::format("the environment map's pixel ({}, {}) is not finite", x, y));
            if (c.x < 0 || c.y < 0 || c.z < 0) {
                c = {std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f)};
                ++negative;
            }
            p.pixels.push_back(c);
        }
    if (negative)
        context.warn(element, fmt::format("{} negative pixels of the environment map become zero", negative));
    return makeEnvironmentMap(std::move(p));
}

LightPtr makeProjectorLight(const Element& element, LoadContext& context) {
    ProjectorParameters p;
    p.toWorld = placement(element, context);
    p.irradiance = emissionProperty(element, "irradiance", context, Rgb(1.0f));
    p.scale = element.number("scale", 1);
    const Vec2i size = p.irradiance->resolution();
    p.aspect = static_cast<float>(std::max(size.x, 1)) / static_cast<float>(std::max(size.y, 1));
    p.tanHalfFovX = readFieldOfView(element).tanHalfWidth(p.aspect);
    return makeProjector(p);
}

/// The intensities of an image: rows from the axis to its other end, columns around it.
PhotometricWeb webOf(const Element& element, const ImageData& image) {
    if (image.height < 2)
        throw element.error(fmt::format("found an image of {} rows, expected 2 at least", image.height));
    PhotometricWeb web;
    const auto angle = [](int i, int n, double whole) { return static_cast<float>(whole * i / n); };
    for (int y = 0; y < image.height; ++y) web.vertical.push_back(angle(y, image.height - 1, 180));
    for (int x = 0; x < image.width; ++x) {
        web.horizontal.push_back(angle(x, image.width, 360));
        for (int y = 0; y < image.height; ++y) {
            const float* v = image.at(x, y);
            web.values.push_back(image.channels >= 3 ? luminance({v[0], v[1], v[2]}) : v[0]);
        }
    }
    return web;
}

/// Neither Mitsuba's, nor another one's parameters: a luminaire of a manufacturer's file, or of an image.
LightPtr makeGoniometric(const Element& element, LoadContext& context) {
    GoniometricLightParameters p;
    p.toWorld = placement(element, context);
    p.scale = emissionColor(element, "intensity", context, Rgb(1.0f));
    if (element.has("data") || element.string("filename", "").ends_with(".exr")) {
        p.web = webOf(element, context.image(element, true));
        return makeGoniometricLight(std::move(p));
    }
    std::vector<std::string> warnings;
    p.web = readIes(context.resolve(element, element.requiredString("filename")), warnings, &context.memory);
    for (const std::string& warning : warnings) context.warn(element, warning);
    return makeGoniometricLight(std::move(p));
}

LightPtr makeCollimated(const Element& element, LoadContext& context) {
    return makeCollimatedLight(
        {context.toWorld(element), emissionColor(element, "power", context, Rgb(1.0f))});
}

void readSamplingWeight(const Element& element, LoadContext& context) {
    if (element.number("sampling_weight", 1) != 1)
        context.warn(element, "\"sampling_weight\" has no effect: lights are chosen by their power");
}

}  // namespace

std::vector<std::string> emitterTypes() { return kEmitterTypes; }

LightPtr makeLight(const Element& element, LoadContext& context) {
    LightPtr (*make)(const Element&, LoadContext&) = nullptr;
    if (element.type == "point") make = makePoint;
    if (element.type == "spot") make = makeSpot;
    if (element.type == "directional") make = makeDirectional;
    if (element.type == "constant") make = makeConstant;
    if (element.type == "envmap") make = makeEnvmap;
    if (element.type == "projector") make = makeProjectorLight;
    if (element.type == "goniometric") make = makeGoniometric;
    if (element.type == "collimated") make = makeCollimated;
    if (element.type == "sunsky" || element.type == "sky" || element.type == "sun") make = makeSunSkyLight;
    if (element.type == "area") throw element.error("an area light has to be nested in the shape that emits");
    if (!make) {
        const std::string message = unknownPlugin(element, "emitter", kEmitterTypes);
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (it is left out)");
        return nullptr;
    }
    readSamplingWeight(element, context);
    LightPtr light = withLocation(element, [&] { return make(element, context); });
    const std::optional<MediumIndex> medium = mediumOf(element, context);
    if (light) light->medium = medium;  // the sun may be below the horizon
    element.checkAllUsed(context.lenient, context.warnings);
    return light;
}

LightPtr makeAreaLight(const Element& element, const Shape& shape, LoadContext& context) {
    if (element.type != "area") {
        const bool isKnown =
            std::find(kEmitterTypes.begin(), kEmitterTypes.end(), element.type) != kEmitterTypes.end();
        const std::string message = isKnown ? "a shape's emitter has to be of type \"area\""
                                            : unknownPlugin(element, "emitter", {"area"});
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (it is left out)");
        return nullptr;
    }
    readSamplingWeight(element, context);
    LightPtr light = withLocation(element, [&] {
        return metrolux::core::makeAreaLight(
            {&shape, emissionProperty(element, "radiance", context, Rgb(1.0f))});
    });
    light->medium = mediumOf(element, context);
    element.checkAllUsed(context.lenient, context.warnings);
    return light;
}

}  // namespace metrolux::core::mitsuba
