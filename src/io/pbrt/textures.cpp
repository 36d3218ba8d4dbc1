#include "io/pbrt/textures.h"

#include "image/image_io.h"

#include <algorithm>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::Maker;

/// Images have t = 0 at their lower edge.
Mapping fromTheTop(Mapping mapping) {
    mapping.toUv = mitsuba::settledMap(
        Transform::fromRows({{1, 0, 0, 0}, {0, -1, 0, 1}, {0, 0, 1, 0}, {0, 0, 0, 1}}) * mapping.toUv);
    return mapping;
}

/// pbrt's marble at t in [0, 1]: a spline of nine colors.
Rgb marbleColor(float t) {
    constexpr float kColors[9][3] = {{.58f, .58f, .6f}, {.58f, .58f, .6f}, {.58f, .58f, .6f},
                                     {.5f, .5f, .5f},   {.6f, .59f, .58f}, {.58f, .58f, .6f},
                                     {.58f, .58f, .6f}, {.2f, .2f, .33f},  {.58f, .58f, .6f}};
    constexpr int kSegments = 6;
    const int first = std::min(static_cast<int>(t * kSegments), kSegments - 1);
    const float x = t * kSegments - static_cast<float>(first), y = 1 - x;
    const float weights[4] = {y * y * y, 3 * y * y * x, 3 * y * x * x, x * x * x};
    Rgb result(0.0f);
    for (int i = 0; i < 4; ++i)
        for (int c = 0; c < 3; ++c) result[c] += 1.5f * weights[i] * kColors[first + i][c];
    return result;
}

}  // namespace

/// Of the texture that is being made.
Mapping Textures::mappingOf(const Parameters& p) const {
    Mapping result;
    result.kind = p.string("mapping", "uv");
    if (result.kind == "uv") {
        const double su = p.number("uscale", 1), sv = p.number("vscale", 1), du = p.number("udelta", 0),
                     dv = p.number("vdelta", 0);
        result.toUv = Transform::fromRows({{su, 0, 0, du}, {0, sv, 0, dv}, {0, 0, 1, 0}, {0, 0, 0, 1}});
        return result;
    }
    if (result.kind != "spherical" && result.kind != "cylindrical" && result.kind != "planar")
        throw p.error(fmt::format("found the mapping \"{}\", expected uv, spherical, cylindrical or planar",
                                  result.kind));
    result.toTexture = mitsuba::settledMap(toWorld_.inverse());
    if (result.kind == "planar") {
        const Vec3d u = p.vector("v1", {1, 0, 0}), v = p.vector("v2", {0, 1, 0});
        result.toTexture = mitsuba::settledMap(Transform::fromRows({{u.x, u.y, u.z, p.number("udelta", 0)},
                                                                    {v.x, v.y, v.z, p.number("vdelta", 0)},
                                                                    {0, 0, 0, 0},
                                                                    {0, 0, 0, 1}}) *
                                               result.toTexture);
    }
    return result;
}

Texture Textures::noise(const std::string& kind, const Parameters& p, bool isColor) const {
    const bool isMarble = kind == "marble";
    Maker element("texture", "noise", p.where());
    element.with("kind", std::string(kind == "fbm" ? "fractal" : kind == "wrinkled" ? "turbulence" : kind));
    element.with("to_texture", mitsuba::settledMap(toWorld_.inverse()));
    if (kind != "windy") {
        element.with("octaves", p.integer("octaves", 8));
        element.with("roughness", p.number("roughness", 0.5));
    }
    if (isMarble) {
        element.with("scale", p.number("scale", 1));
        element.with("variation", p.number("variation", 0.2));
    }
    // Sums of octaves stay within two at the usual roughness, and hardly leave one.
    const float low = isMarble || kind == "wrinkled" ? 0.0f : -2.0f, high = isMarble ? 1.0f : 2.0f;
    element.with("low", double(low)).with("high", double(high));
    constexpr int kColors = 1025;
    std::vector<Rgb> colors;
    for (int i = 0; i < kColors; ++i) {
        const float value = lerp(static_cast<float>(i) / (kColors - 1), low, high);
        // Colors are reflectances, numbers may be anything.
        const float number = isColor ? std::clamp(value, 0.0f, 1.0f) : value;
        colors.push_back(isMarble ? marbleColor(value) : Rgb(number));
    }
    return Texture::noise({element.done(), std::move(colors)}, p.where());
}

Texture Textures::named(const Parameter& parameter) {
    const std::string name = parameter.strings.empty() ? "" : parameter.strings[0];
    const auto found = textures_.find(name);
    if (found == textures_.end())
        throw parameter.error(fmt::format("found no texture of the name \"{}\" before this", name));
    return found->second;
}

Texture Textures::color(const Parameters& parameters, const std::string& name, const Rgb& fallback,
                        const ColorSpace& space) {
    const Parameter* p = parameters.find(name);
    if (!p) return Texture(fallback);
    return p->type == "texture" ? named(*p) : Texture(surfaceColor(*p, space, reading_));
}

Texture Textures::number(const Parameters& parameters, const std::string& name, double fallback) {
    const Parameter* p = parameters.find(name);
    if (!p) return Texture(Rgb(static_cast<float>(fallback)));
    return p->type == "texture" ? named(*p)
                                : Texture(Rgb(static_cast<float>(parameters.number(name, fallback))));
}

Texture Textures::imageFile(const std::string& file, const Parameters& p, bool raw, const ColorSpace& space) {
    const std::string encoding = p.string("encoding", raw ? "linear" : "sRGB");
    double gamma = 0;
    if (encoding.starts_with("gamma ")) gamma = std::strtod(encoding.c_str() + 6, nullptr);
    if (encoding != "sRGB" && encoding != "linear" && !(gamma > 0))
        throw p.error(fmt::format("found the encoding \"{}\", expected sRGB, linear or a gamma", encoding));
    const std::filesystem::path found = reading_.find(file, p.where());
    const bool isLinear = encoding != "sRGB";
    const auto [entry, isNew] = images_.try_emplace({found.string(), isLinear});
    if (isNew) {
        const ImageData data = readImage(found, isLinear, &reading_.memory);
        const auto texels = static_cast<size_t>(data.width) * static_cast<size_t>(data.height);
        reading_.memory.take(3 * texels * sizeof(float), "a texture");
        auto pixels = std::make_shared<std::vector<float>>();
        pixels->reserve(3 * texels);
        for (size_t i = 0; i < texels; ++i) {
            const float* v = &data.pixels[i * static_cast<size_t>(data.channels)];
            const Rgb color = data.channels >= 3 ? space.convert({v[0], v[1], v[2]}) : Rgb(v[0]);
            pixels->insert(pixels->end(), {color.x, color.y, color.z});
        }
        entry->second = {data.width, data.height, std::move(pixels)};
    }
    Texture::Image image = entry->second;
    std::string wrap = p.string("wrap", "repeat");
    if (wrap == "black") {
        reading_.warn(p.error("the wrap mode \"black\" is read as clamp"));
        wrap = "clamp";
    }
    if (wrap != "repeat" && wrap != "clamp")
        throw p.error(fmt::format("found the wrap mode \"{}\", expected repeat, clamp or black", wrap));
    image.wrap = wrap;
    image.nearest = p.string("filter", "bilinear") == "point";
    p.ignore({"maxanisotropy", "trilinear", "gamma"});
    Texture result = Texture::image(std::move(image), fromTheTop(mappingOf(p)), p.where());
    if (gamma > 0)
        result = result.changed(
            [gamma](const Rgb& c) {
                const auto power = [gamma](float x) {
                    return static_cast<float>(std::pow(double(x), gamma));
                };
                return Rgb(power(c.x), power(c.y), power(c.z));
            },
            reading_.memory);
    return result;
}

void Textures::define(const std::string& name, const std::string& type, const std::string& kind,
                      const Parameters& parameters, const ColorSpace& space, const Transform& toWorld) {
    toWorld_ = toWorld;
    if (type != "float" && type != "spectrum" && type != "color")
        throw parameters.error(fmt::format("found the type \"{}\", expected float or spectrum", type));
    textures_.insert_or_assign(name, make(kind, parameters, type != "float", space));
    parameters.checkAllUsed(reading_);
}

Texture Textures::make(const std::string& kind, const Parameters& p, bool isColor, const ColorSpace& space) {
    const auto value = [&](const char* name, double fallback) {
        return isColor ? color(p, name, Rgb(static_cast<float>(fallback)), space) : number(p, name, fallback);
    };
    constexpr auto kTimes = Texture::Operation::Product;
    MemoryBudget& memory = reading_.memory;
    if (kind == "constant") return value("value", 1);
    if (kind == "scale") {
        const bool isOld = !p.has("tex") && p.has("tex1");  // of version 3
        return Texture::combined(value(isOld ? "tex1" : "tex", 1),
                                 isOld ? value("tex2", 1) : number(p, "scale", 1), kTimes, memory);
    }
    if (kind == "mix") {
        const Texture amount = number(p, "amount", 0.5);
        const Texture rest = amount.changed([](const Rgb& x) { return Rgb(1.0f) - x; }, memory);
        return Texture::combined(Texture::combined(value("tex1", 0), rest, kTimes, memory),
                                 Texture::combined(value("tex2", 1), amount, kTimes, memory),
                                 Texture::Operation::Sum, memory);
    }
    if (kind == "imagemap") {
        const auto scale = static_cast<float>(p.number("scale", 1));
        const bool inverts = p.boolean("invert", false);
        Texture image = imageFile(p.requiredString("filename"), p, false, isColor ? space : ColorSpace());
        if (!isColor) image = image.changed([](const Rgb& c) { return Rgb((c.x + c.y + c.z) / 3); }, memory);
        if (scale == 1 && !inverts) return image;
        return image.changed(
            [=](const Rgb& c) {
                const Rgb scaled = c * scale;
                return inverts ? Rgb(std::max(0.0f, 1 - scaled.x), std::max(0.0f, 1 - scaled.y),
                                     std::max(0.0f, 1 - scaled.z))
                               : scaled;
            },
            memory);
    }
    if (kind == "checkerboard") {
        const int64_t dimension = p.integer("dimension", 2);
        if (dimension != 2 && dimension != 3)
            throw p.error(fmt::format("found the dimension {}, expected 2 or 3", dimension));
        p.ignore({"aamode"});  // of version 3
        return Texture::choice(dimension == 2 ? "squares" : "cubes", value("tex1", 1), value("tex2", 0),
                               dimension == 2 ? mappingOf(p) : Mapping{"uv", toWorld_.inverse(), {}},
                               p.where());
    }
    if (kind == "dots")
        return Texture::choice("discs", value("inside", 1), value("outside", 0), mappingOf(p), p.where());
    for (const char* name : {"fbm", "wrinkled", "windy", "marble"})
        if (kind == name) return noise(kind, p, isColor);
    reading_.refuse(p.error(fmt::format(
                        "textures of the class \"{}\" are not supported, expected one of constant, scale, "
                        "mix, imagemap, checkerboard, dots, fbm, wrinkled, windy and marble",
                        kind)),
                    "a constant 0.5 stands in");
    for (const Parameter& parameter : p.all()) p.find(parameter.name);
    return Texture(Rgb(0.5f));
}

}  // namespace metrolux::core::pbrt
