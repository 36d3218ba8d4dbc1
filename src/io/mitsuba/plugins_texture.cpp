/// Textures, and the properties that may be a value or a texture.

#include "image/image_io.h"
#include "io/mitsuba/context.h"
#include "io/mitsuba/spectrum.h"
#include "scattering/textures/bitmap_texture.h"
#include "scattering/textures/checkerboard.h"
#include "scattering/textures/constant.h"
#include "scattering/textures/mesh_attribute.h"

#include <array>

namespace metrolux::core::mitsuba {
namespace {

const std::vector<std::string> kTextureTypes = {"bitmap", "checkerboard", "mesh_attribute", "rawconstant"};

/// The 4x4 matrix of a <transform> as a map of the plane: its third row and column do not matter.
UvTransform uvTransform(const Element& element) {
    const Transform t = element.transform("to_uv");
    const auto at = [&](int row, int column) { return static_cast<float>(t.at(row, column)); };
    return {{{at(0, 0), at(0, 1), at(0, 3)}, {at(1, 0), at(1, 1), at(1, 3)}}};
}

/// The value of a string property out of a list.
template <class T>
T choice(const Element& element, const std::string& name,
         const std::vector<std::pair<std::string, T>>& choices) {
    const std::string found = element.string(name, choices.front().first);
    std::string known;
    for (const auto& [text, value] : choices) {
        if (found == text) return value;
        known += (known.empty() ? "" : ", ") + text;
    }
    const Property* property = element.find(name);
    throw element.error(*property, fmt::format("found \"{}\", expected one of: {}", found, known));
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

TexturePtr bitmap(const Element& element, LoadContext& context) {
    using P = BitmapTextureParameters;
    P p;
    p.filter = choice<P::Filter>(element, "filter_type",
                                 {{"bilinear", P::Filter::Bilinear}, {"nearest", P::Filter::Nearest}});
    p.wrap = choice<P::Wrap>(
        element, "wrap_mode",
        {{"repeat", P::Wrap::Repeat}, {"mirror", P::Wrap::Mirror}, {"clamp", P::Wrap::Clamp}});
    p.toUv = uvTransform(element);
    element.ignore("format");  // storage precision: always float here
    element.ignore("accel");   // of GPUs
    const bool raw = element.boolean("raw", false);
    const auto file = context.resolve(element, element.requiredString("filename"));
    try {
        ImageData image = readImage(file, raw, &context.memory);
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
    if (const Vec3f* v = std::get_if<Vec3f>(&property->value)) return makeConstantTexture({v->x, v->y, v->z});
    if (const RgbValue* rgb = std::get_if<RgbValue>(&property->value)) return makeConstantTexture(rgb->value);
    return makeConstantTexture(Rgb(element.number("value", 0)));
}

std::string joined(const std::vector<std::string>& names) {
    std::string result;
    for (const std::string& name : names) result += (result.empty() ? "" : ", ") + name;
    return result;
}

/// The color of a number, <rgb> or <spectrum>, or nothing when the property is an element.
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

TexturePtr nestedTexture(const Element& element, const Property& property, LoadContext& context,
                         bool emission) {
    const ElementPtr& child = std::get<ElementPtr>(property.value);
    if (!child || child->tag != "texture")
        throw element.error(property,
                            fmt::format("found a <{}>, expected a <texture>", child ? child->tag : "?"));
    return makeTexture(*child, context, emission);
}

/// What the squares hold is known to the reader of the texture only, so that no range is imposed here.
TexturePtr checkerboard(const Element& element, LoadContext& context, bool emission) {
    const auto color = [&](const std::string& name, float fallback) {
        const Property* property = element.find(name);
        if (!property) return makeConstantTexture(Rgb(fallback));
        const auto value =
            constantColor(element, *property, emission ? emissionFromSpectrum : reflectanceFromSpectrum);
        return value ? makeConstantTexture(*value) : nestedTexture(element, *property, context, emission);
    };
    CheckerboardParameters p;
    p.color0 = color("color0", 0.4f);
    p.color1 = color("color1", 0.2f);
    p.toUv = uvTransform(element);
    return makeCheckerboard(p);
}

}  // namespace

TexturePtr makeTexture(const Element& element, LoadContext& context, bool emission) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return std::static_pointer_cast<const Texture>(found->second);
    TexturePtr result;
    if (element.type == "bitmap") {
        result = bitmap(element, context);
    } else if (element.type == "checkerboard") {
        result = checkerboard(element, context, emission);
    } else if (element.type == "mesh_attribute") {
        result = meshAttribute(element);
    } else if (element.type == "rawconstant") {
        result = rawConstant(element);
    } else {
        const std::string nearest = nearestName(element.type, kTextureTypes);
        const std::string message =
            nearest.empty() ? fmt::format("unknown texture type, expected one of: {}", joined(kTextureTypes))
                            : fmt::format("unknown texture type; did you mean \"{}\"?", nearest);
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
