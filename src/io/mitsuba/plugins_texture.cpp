/// Textures, and the properties that may be a value or a texture.

#include "image/image_io.h"
#include "io/mitsuba/choice.h"
#include "io/mitsuba/context.h"
#include "io/mitsuba/pattern_textures.h"
#include "io/mitsuba/spectrum.h"
#include "io/mitsuba/spectrum_plugins.h"
#include "io/mitsuba/unknown_plugins.h"
#include "scattering/textures/bitmap_texture.h"
#include "scattering/textures/checkerboard.h"
#include "scattering/textures/constant.h"
#include "scattering/textures/lines.h"
#include "scattering/textures/mesh_attribute.h"
#include "scattering/textures/scaled.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

/// The 4x4 matrix of a <transform> as a map of the plane: its third row and column do not matter.
UvTransform uvTransform(const Element& element) {
    const Transform t = element.transform("to_uv", true);
    const auto at = [&](int row, int column) { return static_cast<float>(t.at(row, column)); };
    return {{{at(0, 0), at(0, 1), at(0, 3)}, {at(1, 0), at(1, 1), at(1, 3)}}};
}

/// The one channel of an image that the parameter `channel` of 0.6 names.
ImageData onlyChannel(const Element& element, ImageData&& image) {
    const std::vector<std::vector<std::string>> names = {
        {"y"}, {"y", "a"}, {"r", "g", "b"}, {"r", "g", "b", "a"}};  // by the number of channels
    const auto& own = names[static_cast<size_t>(std::clamp(image.channels, 1, 4) - 1)];
    const std::string wanted = element.string("channel", "");
    const bool isGray = own.size() < 3;
    const auto at = std::find(own.begin(), own.end(), isGray && wanted != "a" ? "y" : wanted);
    if (at == own.end())
        throw Error("found the channel \"{}\", expected one of the image's: {}", wanted,
                    fmt::join(own, ", "));
    ImageData result{image.width, image.height, 1, {}};
    const auto channel = static_cast<size_t>(at - own.begin());
    for (size_t i = channel; i < image.pixels.size(); i += own.size())
        result.pixels.push_back(image.pixels[i]);
    return result;
}

/// Colors of an image without its alpha channel: 1 or 3 channels.
std::vector<float> withoutAlpha(ImageData&& image, int channels) {
    if (image.channels == channels) return std::move(image.pixels);
    std::vector<float> result;
    const size_t count = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
    result.reserve(count * static_cast<size_t>(channels));
    for (size_t i = 0; i < count; ++i) {
        const float* pixel = &image.pixels[i * static_cast<size_t>(image.channels)];
        result.insert(result.end(), pixel, pixel + channels);
    }
    return result;
}

void readWrapModes(const Element& element, BitmapTextureParameters& p) {
    using Wrap = BitmapTextureParameters::Wrap;
    std::vector<std::pair<std::string, Wrap>> modes = {
        {"repeat", Wrap::Repeat}, {"mirror", Wrap::Mirror}, {"clamp", Wrap::Clamp}};
    if (element.isLegacy()) modes.insert(modes.end(), {{"zero", Wrap::Zero}, {"one", Wrap::One}});
    p.wrapU = p.wrapV = choice<Wrap>(element, "wrap_mode", modes);
    if (!element.isLegacy()) return;
    if (element.has("wrap_mode_u")) p.wrapU = choice<Wrap>(element, "wrap_mode_u", modes);
    if (element.has("wrap_mode_v")) p.wrapV = choice<Wrap>(element, "wrap_mode_v", modes);
}

TexturePtr bitmap(const Element& element, LoadContext& context) {
    using P = BitmapTextureParameters;
    P p;
    p.filter = choice<P::Filter>(element, "filter_type",
                                 {{"bilinear", P::Filter::Bilinear}, {"nearest", P::Filter::Nearest}});
    readWrapModes(element, p);
    p.toUv = uvTransform(element);
    element.ignore("format");  // storage precision: always float here
    element.ignore("accel");   // of GPUs
    const bool raw = element.boolean("raw", false);
    ImageData image = context.image(element, raw);
    try {
        if (element.isLegacy() && element.has("channel")) image = onlyChannel(element, std::move(image));
        p.width = image.width;
        p.height = image.height;
        p.channels = image.channels >= 3 ? 3 : 1;
        p.pixels = std::make_shared<const std::vector<float>>(withoutAlpha(std::move(image), p.channels));
        return makeBitmapTexture(p);
    } catch (const Error& problem) {
        throw element.error(problem.what());
    }
}

TexturePtr meshAttribute(const Element& element) {
    MeshAttributeParameters p;
    p.name = element.requiredString("name");
    p.scale = element.number("scale", 1);
    if (!p.name.starts_with("vertex_") && !p.name.starts_with("face_"))
        throw element.error(fmt::format(
            "found the attribute \"{}\", expected a name that begins with vertex_ or face_", p.name));
    return makeMeshAttribute(p);
}

/// One number or three, as they are.
TexturePtr rawConstant(const Element& element) {
    const Property* property = element.find("value");
    if (!property) throw element.error("has no \"value\", expected a <float>, <rgb> or <vector>");
    property->used = true;
    if (const Vec3d* v = std::get_if<Vec3d>(&property->value)) {
        const Vec3f color(*v);
        return makeConstantTexture({color.x, color.y, color.z});
    }
    if (const RgbValue* rgb = std::get_if<RgbValue>(&property->value)) return makeConstantTexture(rgb->value);
    return makeConstantTexture(Rgb(element.number("value", 0)));
}

TexturePtr nestedTexture(const Element& element, const Property& property, LoadContext& context,
                         bool emission) {
    const ElementPtr& child = std::get<ElementPtr>(property.value);
    if (!child || child->tag != "texture")
        throw element.error(property,
                            fmt::format("found a <{}>, expected a <texture>", child ? child->tag : "?"));
    return makeTexture(*child, context, emission);
}

TexturePtr checkerboard(const Element& element, LoadContext& context, bool emission) {
    CheckerboardParameters p;
    p.color0 = patternColor(element, "color0", 0.4f, context, emission);
    p.color1 = patternColor(element, "color1", 0.2f, context, emission);
    p.toUv = uvTransform(element);
    return makeCheckerboard(p);
}

/// 0.6: lines on a ground.
TexturePtr lines(const Element& element, LoadContext& context, bool emission) {
    LinesParameters p;
    p.color0 = patternColor(element, "color0", 0.2f, context, emission);
    p.color1 = patternColor(element, "color1", 0.4f, context, emission);
    p.lineWidth = element.number("line_width", p.lineWidth);
    p.toUv = uvTransform(element);
    return makeLines(p);
}

/// 0.6: a nested texture times a number or a color.
TexturePtr scaled(const Element& element, LoadContext& context, bool emission) {
    ScaledTextureParameters p;
    if (const Property* property = element.find("scale")) {
        const auto scale = constantColor(element, *property, unboundedFromSpectrum);
        if (!scale) throw element.error(*property, "found an element, expected a number or a color");
        p.scale = *scale;
    }
    const auto nested = element.childrenOf("texture");
    if (nested.size() > 1 || (nested.empty() && !element.has("value")))
        throw element.error(fmt::format("found {} nested <texture> elements, expected one", nested.size()));
    p.texture = nested.empty() ? textureProperty(element, "value", context, Rgb(1.0f))
                               : makeTexture(*nested[0], context, emission);
    return makeScaledTexture(p);
}

/// A spectrum plugin in the place of a texture.
TexturePtr fromSpectrum(const Element& element, bool emission) {
    const auto value = spectrumFromPlugin(element);
    if (const RgbValue* rgb = std::get_if<RgbValue>(&value)) return makeConstantTexture(rgb->value);
    const SpectrumValue& spectrum = std::get<SpectrumValue>(value);
    return makeConstantTexture(emission ? emissionFromSpectrum(spectrum) : reflectanceFromSpectrum(spectrum));
}

bool isPattern(const std::string& type) {
    const auto& names = patternTextureNames();
    return std::find(names.begin(), names.end(), type) != names.end();
}

std::vector<std::string> knownTypes() {
    std::vector<std::string> result = {"bitmap",         "checkerboard", "gridtexture",
                                       "mesh_attribute", "rawconstant",  "scale"};
    for (const auto* names : {&spectrumPluginNames(), &patternTextureNames()})
        result.insert(result.end(), names->begin(), names->end());
    return result;
}

}  // namespace

std::optional<Rgb> constantColor(const Element& element, const Property& property,
                                 Rgb (*convert)(const SpectrumValue&)) {
    property.used = true;
    if (const double* v = std::get_if<double>(&property.value)) return Rgb(static_cast<float>(*v));
    if (const int64_t* v = std::get_if<int64_t>(&property.value)) return Rgb(static_cast<float>(*v));
    if (const RgbValue* v = std::get_if<RgbValue>(&property.value)) return v->value;
    if (const SpectrumValue* v = std::get_if<SpectrumValue>(&property.value)) return convert(*v);
    if (std::holds_alternative<ElementPtr>(property.value)) return std::nullopt;
    throw element.error(property, "expected a number, an <rgb>, a <spectrum> or a <texture>");
}

TexturePtr patternColor(const Element& element, const std::string& name, float fallback, LoadContext& context,
                        bool emission) {
    const Property* property = element.find(name);
    if (!property) return makeConstantTexture(Rgb(fallback));
    const auto value =
        constantColor(element, *property, emission ? emissionFromSpectrum : reflectanceFromSpectrum);
    return value ? makeConstantTexture(*value) : nestedTexture(element, *property, context, emission);
}

TexturePtr makeTexture(const Element& element, LoadContext& context, bool emission) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return std::static_pointer_cast<const Texture>(found->second);
    TexturePtr result;
    if (element.type == "bitmap") {
        result = bitmap(element, context);
    } else if (element.type == "checkerboard") {
        result = checkerboard(element, context, emission);
    } else if (element.type == "gridtexture" && element.isLegacy()) {
        result = lines(element, context, emission);
    } else if (element.type == "mesh_attribute") {
        result = meshAttribute(element);
    } else if (element.type == "rawconstant") {
        result = rawConstant(element);
    } else if (element.type == "scale" && element.isLegacy()) {
        result = scaled(element, context, emission);
    } else if (isSpectrumPlugin(element.type)) {
        result = fromSpectrum(element, emission);
    } else if (isPattern(element.type) && !emission) {
        result = makePatternTexture(element, context);
    } else {
        const std::string message = unknownPlugin(element, "texture", knownTypes());
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (a gray of 0.5 stands in)");
        result = makeConstantTexture(Rgb(0.5f));
        context.built[&element] = result;
        return result;
    }
    element.checkAllUsed(context.lenient, context.warnings);
    context.built[&element] = result;
    return result;
}

std::vector<std::string> textureTypes() { return knownTypes(); }

TexturePtr textureProperty(const Element& element, const std::string& name, LoadContext& context,
                           const Rgb& fallback) {
    const Property* property = element.find(name);
    if (!property) return makeConstantTexture(fallback);
    const std::optional<Rgb> color = constantColor(element, *property, reflectanceFromSpectrum);
    if (!color) return nestedTexture(element, *property, context, false);
    Rgb clamped = *color;
    for (int k = 0; k < 3; ++k) clamped[k] = std::clamp(clamped[k], 0.0f, 1.0f);
    if (clamped != *color)
        context.warn(element, fmt::format("\"{}\" is ({}, {}, {}), limited to [0, 1]", name, color->x,
                                          color->y, color->z));
    return makeConstantTexture(clamped);
}

TexturePtr scalarTextureProperty(const Element& element, const std::string& name, LoadContext& context,
                                 float fallback) {
    const Property* property = element.find(name);
    if (!property) return makeConstantTexture(Rgb(fallback));
    const std::optional<Rgb> color = constantColor(element, *property, unboundedFromSpectrum);
    return color ? makeConstantTexture(*color) : nestedTexture(element, *property, context, false);
}

TexturePtr emissionProperty(const Element& element, const std::string& name, LoadContext& context,
                            const Rgb& fallback) {
    const Property* property = element.find(name);
    if (!property) return makeConstantTexture(fallback);
    const std::optional<Rgb> color = constantColor(element, *property, emissionFromSpectrum);
    if (!color) return nestedTexture(element, *property, context, true);
    if (std::min({color->x, color->y, color->z}) < 0)
        throw element.error(*property, "found a negative value, expected an emission of zero or more");
    return makeConstantTexture(*color);
}

Rgb unboundedColor(const Element& element, const std::string& name, LoadContext&, const Rgb& fallback) {
    const Property* property = element.find(name);
    if (!property) return fallback;
    const std::optional<Rgb> color = constantColor(element, *property, unboundedFromSpectrum);
    if (!color)
        throw element.error(*property, "found an element, expected a number, an <rgb> or a <spectrum>");
    return *color;
}

}  // namespace metrolux::core::mitsuba
