#include "io/pbrt/textures.h"

#include "image/image_io.h"
#include "io/mitsuba/maker.h"

#include <algorithm>

namespace metrolux::core::pbrt {
namespace {

using mitsuba::ElementPtr;
using mitsuba::Maker;
using mitsuba::PixelArray;
using mitsuba::RgbValue;

bool isSame(const Transform& a, const Transform& b) {
    for (int i = 0; i < 16; ++i)
        if (a.at(i / 4, i % 4) != b.at(i / 4, i % 4)) return false;
    return true;
}

/// uv of the surface to those of pbrt's mapping.
Transform mappingOf(const Parameters& p, Reading& reading) {
    if (const std::string kind = p.string("mapping", "uv"); kind != "uv") {
        reading.refuse(p.error(fmt::format("the mapping \"{}\" is not supported, expected \"uv\"", kind)),
                       "read as uv");
        p.ignore({"v1", "v2"});
    }
    const double su = p.number("uscale", 1), sv = p.number("vscale", 1), du = p.number("udelta", 0),
                 dv = p.number("vdelta", 0);
    return Transform::fromRows({{su, 0, 0, du}, {0, sv, 0, dv}, {0, 0, 1, 0}, {0, 0, 0, 1}});
}

/// Images have t = 0 at their lower edge.
Transform fromTheTop(const Transform& map) {
    return mitsuba::settledMap(
        Transform::fromRows({{1, 0, 0, 0}, {0, -1, 0, 1}, {0, 0, 1, 0}, {0, 0, 0, 1}}) * map);
}

}  // namespace

Texture Texture::checkerboard(Texture even, Texture odd, const Transform& toUv, const Location& where) {
    Texture result{Rgb(0.0f)};
    constexpr int kDeepest = 8;
    result.kind_ = Kind::Checkerboard;
    result.depth_ = 1 + std::max(even.depth_, odd.depth_);
    if (result.depth_ > kDeepest)
        throw Error("{}: checkerboards are nested more than {} levels deep", where.str(), kDeepest);
    result.even_ = std::make_shared<const Texture>(std::move(even));
    result.odd_ = std::make_shared<const Texture>(std::move(odd));
    result.toUv_ = toUv;
    result.where_ = where;
    return result;
}

Texture Texture::image(Image image, const Transform& toUv, const Location& where) {
    Texture result{Rgb(0.0f)};
    result.kind_ = Kind::Image;
    result.image_ = std::move(image);
    result.toUv_ = toUv;
    result.where_ = where;
    return result;
}

Rgb Texture::largest() const {
    if (kind_ == Kind::Constant) return constant_;
    const auto larger = [](const Rgb& a, const Rgb& b) {
        return Rgb(std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z));
    };
    if (kind_ == Kind::Checkerboard) return larger(even_->largest(), odd_->largest());
    Rgb result(0.0f);
    const std::vector<float>& p = *image_.pixels;
    for (size_t i = 0; i + 2 < p.size(); i += 3) result = larger(result, {p[i], p[i + 1], p[i + 2]});
    return result;
}

Rgb Texture::mean() const {
    if (kind_ == Kind::Constant) return constant_;
    if (kind_ == Kind::Checkerboard) return (even_->mean() + odd_->mean()) * 0.5f;
    double sum[3] = {0, 0, 0};
    const std::vector<float>& p = *image_.pixels;
    for (size_t i = 0; i < p.size(); ++i) sum[i % 3] += double(p[i]);
    const double n = std::max<double>(1, double(p.size() / 3));
    return {float(sum[0] / n), float(sum[1] / n), float(sum[2] / n)};
}

Texture Texture::changed(const std::function<Rgb(const Rgb&)>& change, MemoryBudget& memory) const {
    Texture result = *this;
    if (kind_ == Kind::Constant) {
        result.constant_ = change(constant_);
    } else if (kind_ == Kind::Checkerboard) {
        result.even_ = std::make_shared<const Texture>(even_->changed(change, memory));
        result.odd_ = std::make_shared<const Texture>(odd_->changed(change, memory));
    } else {
        memory.take(image_.pixels->size() * sizeof(float), "a texture");
        auto pixels = std::make_shared<std::vector<float>>(*image_.pixels);
        for (size_t i = 0; i + 2 < pixels->size(); i += 3) {
            float* const p = &(*pixels)[i];
            const Rgb color = change({p[0], p[1], p[2]});
            for (int c = 0; c < 3; ++c) p[c] = color[c];
        }
        result.image_.pixels = std::move(pixels);
    }
    return result;
}

/// Of an image, between its texels; u and v in [0, 1] from the upper left corner.
Rgb Texture::at(double u, double v) const {
    const auto texel = [](double x, int n) { return std::clamp(static_cast<int>(x * n), 0, n - 1); };
    const auto x = static_cast<size_t>(texel(u, image_.width)),
               y = static_cast<size_t>(texel(v, image_.height));
    const float* p = &(*image_.pixels)[3 * (y * static_cast<size_t>(image_.width) + x)];
    return {p[0], p[1], p[2]};
}

Texture Texture::combined(const Texture& a, const Texture& b,
                          const std::function<Rgb(const Rgb&, const Rgb&)>& f, MemoryBudget& memory) {
    if (b.isConstant()) return a.changed([&](const Rgb& x) { return f(x, b.constant_); }, memory);
    if (a.isConstant()) return b.changed([&](const Rgb& x) { return f(a.constant_, x); }, memory);
    if (a.kind_ == Kind::Checkerboard)
        return checkerboard(combined(*a.even_, b, f, memory), combined(*a.odd_, b, f, memory), a.toUv_,
                            a.where_);
    if (b.kind_ == Kind::Checkerboard)
        return checkerboard(combined(a, *b.even_, f, memory), combined(a, *b.odd_, f, memory), b.toUv_,
                            b.where_);
    if (!isSame(a.toUv_, b.toUv_) || a.image_.wrap != b.image_.wrap)
        throw Error(
            "{}: two images are combined that are mapped to the surface in different ways, which is not "
            "supported (the other at {})",
            a.where_.str(), b.where_.str());
    Texture result = a;
    result.image_.width = std::max(a.image_.width, b.image_.width);
    result.image_.height = std::max(a.image_.height, b.image_.height);
    const auto w = static_cast<size_t>(result.image_.width), h = static_cast<size_t>(result.image_.height);
    memory.take(3 * w * h * sizeof(float), "a texture");
    auto pixels = std::make_shared<std::vector<float>>(3 * w * h);
    for (size_t i = 0; i < w * h; ++i) {
        const double u = (double(i % w) + 0.5) / double(w), v = (double(i / w) + 0.5) / double(h);
        const Rgb color = f(a.at(u, v), b.at(u, v));
        for (size_t c = 0; c < 3; ++c) (*pixels)[3 * i + c] = color[static_cast<int>(c)];
    }
    result.image_.pixels = std::move(pixels);
    return result;
}

void Texture::addTo(Maker& element, const std::string& name, bool asNumber) const {
    if (!isConstant())
        element.with(name, this->element(asNumber));
    else if (asNumber)
        element.with(name, double(constant_.x));
    else
        element.with(name, RgbValue{constant_});
}

ElementPtr Texture::element(bool asNumber) const {
    if (kind_ == Kind::Image)
        return Maker("texture", "bitmap", where_)
            .with("data", PixelArray{image_.width, image_.height, 3, *image_.pixels, image_.pixels})
            .with("raw", true)
            .with("to_uv", toUv_)
            .with("wrap_mode", image_.wrap)
            .with("filter_type", std::string(image_.nearest ? "nearest" : "bilinear"))
            .done();
    Maker result("texture", "checkerboard", where_);
    // Ours has two squares in the unit of uv, and exchanges its colors where it gives numbers.
    const Transform half = mitsuba::settledMap(Transform::scale({0.5f, 0.5f, 1}) * toUv_);
    result.with("to_uv", half);
    even_->addTo(result, asNumber ? "color1" : "color0", asNumber);
    odd_->addTo(result, asNumber ? "color0" : "color1", asNumber);
    return result.done();
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
    Texture result = Texture::image(std::move(image), fromTheTop(mappingOf(p, reading_)), p.where());
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
                      const Parameters& parameters, const ColorSpace& space) {
    if (type != "float" && type != "spectrum" && type != "color")
        throw parameters.error(fmt::format("found the type \"{}\", expected float or spectrum", type));
    textures_.insert_or_assign(name, make(kind, parameters, type != "float", space));
    parameters.checkAllUsed(reading_);
}

Texture Textures::make(const std::string& kind, const Parameters& p, bool isColor, const ColorSpace& space) {
    const auto value = [&](const char* name, double fallback) {
        return isColor ? color(p, name, Rgb(static_cast<float>(fallback)), space) : number(p, name, fallback);
    };
    const auto times = [](const Rgb& a, const Rgb& b) { return a * b; };
    MemoryBudget& memory = reading_.memory;
    if (kind == "constant") return value("value", 1);
    if (kind == "scale") {
        const bool isOld = !p.has("tex") && p.has("tex1");  // of version 3
        return Texture::combined(value(isOld ? "tex1" : "tex", 1),
                                 isOld ? value("tex2", 1) : number(p, "scale", 1), times, memory);
    }
    if (kind == "mix") {
        const Texture amount = number(p, "amount", 0.5);
        const Texture rest = amount.changed([](const Rgb& x) { return Rgb(1.0f) - x; }, memory);
        return Texture::combined(
            Texture::combined(value("tex1", 0), rest, times, memory),
            Texture::combined(value("tex2", 1), amount, times, memory),
            [](const Rgb& a, const Rgb& b) { return a + b; }, memory);
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
    if (kind == "checkerboard" && p.integer("dimension", 2) == 2)
        return Texture::checkerboard(value("tex1", 1), value("tex2", 0), mappingOf(p, reading_), p.where());
    reading_.refuse(
        p.error(fmt::format("textures of the class \"{}\" are not supported, expected constant, scale, mix, "
                            "imagemap or checkerboard (of dimension 2)",
                            kind)),
        "a constant 0.5 stands in");
    for (const Parameter& parameter : p.all()) p.find(parameter.name);
    return Texture(Rgb(0.5f));
}

}  // namespace metrolux::core::pbrt
