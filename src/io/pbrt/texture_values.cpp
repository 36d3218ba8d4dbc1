#include "io/pbrt/textures.h"

#include <algorithm>

namespace metrolux::core::pbrt {

using mitsuba::ElementPtr;
using mitsuba::Maker;
using mitsuba::PixelArray;
using mitsuba::RgbValue;

namespace {

bool isSame(const Transform& a, const Transform& b) {
    for (int i = 0; i < 16; ++i)
        if (a.at(i / 4, i % 4) != b.at(i / 4, i % 4)) return false;
    return true;
}

}  // namespace

bool operator==(const Mapping& a, const Mapping& b) {
    return a.kind == b.kind && isSame(a.toUv, b.toUv) && (a.kind == "uv" || isSame(a.toTexture, b.toTexture));
}

void Texture::requireDepth() const {
    constexpr int kDeepest = 8;
    if (depth_ > kDeepest)
        throw Error("{}: textures are nested more than {} levels deep", where_.str(), kDeepest);
}

Texture Texture::choice(const char* kind, Texture first, Texture second, const Mapping& mapping,
                        const Location& where) {
    Texture result{Rgb(0.0f)};
    result.kind_ = Kind::Choice;
    result.choice_ = kind;
    result.depth_ = 1 + std::max(first.depth_, second.depth_);
    result.first_ = std::make_shared<const Texture>(std::move(first));
    result.second_ = std::make_shared<const Texture>(std::move(second));
    result.mapping_ = mapping;
    result.where_ = where;
    result.requireDepth();
    return result;
}

Texture Texture::noise(Noise noise, const Location& where) {
    Texture result{Rgb(0.0f)};
    result.kind_ = Kind::Noise;
    result.noise_.emplace(std::move(noise));
    result.where_ = where;
    return result;
}

/// What is computed where a surface is hit.
Texture Texture::later(const Texture& a, const Texture& b, Operation operation) {
    Texture result{Rgb(0.0f)};
    result.kind_ = Kind::Combination;
    result.operation_ = operation;
    result.depth_ = 1 + std::max(a.depth_, b.depth_);
    result.first_ = std::make_shared<const Texture>(a);
    result.second_ = std::make_shared<const Texture>(b);
    result.where_ = a.where_;
    result.requireDepth();
    return result;
}

Texture Texture::image(Image image, const Mapping& mapping, const Location& where) {
    Texture result{Rgb(0.0f)};
    result.kind_ = Kind::Image;
    result.image_ = std::move(image);
    result.mapping_ = mapping;
    result.where_ = where;
    return result;
}

Rgb Texture::largest() const {
    const auto larger = [](const Rgb& a, const Rgb& b) {
        return Rgb(std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z));
    };
    Rgb result(0.0f);
    switch (kind_) {
        case Kind::Constant:
            return constant_;
        case Kind::Choice:
            return larger(first_->largest(), second_->largest());
        case Kind::Combination:
            return operation_ == Operation::Product ? first_->largest() * second_->largest()
                                                    : first_->largest() + second_->largest();
        case Kind::Noise:
            for (const Rgb& color : noise_->colors) result = larger(result, color);
            return result;
        case Kind::Image:
            break;
    }
    const std::vector<float>& p = *image_.pixels;
    for (size_t i = 0; i + 2 < p.size(); i += 3) result = larger(result, {p[i], p[i + 1], p[i + 2]});
    return result;
}

Rgb Texture::mean() const {
    double sum[3] = {0, 0, 0};
    switch (kind_) {
        case Kind::Constant:
            return constant_;
        case Kind::Choice:
            return (first_->mean() + second_->mean()) * 0.5f;
        case Kind::Combination:
            return operation_ == Operation::Product ? first_->mean() * second_->mean()
                                                    : first_->mean() + second_->mean();
        case Kind::Noise:
            return noise_->colors[noise_->colors.size() / 2];
        case Kind::Image:
            break;
    }
    const std::vector<float>& p = *image_.pixels;
    for (size_t i = 0; i < p.size(); ++i) sum[i % 3] += double(p[i]);
    const double n = std::max<double>(1, double(p.size() / 3));
    return {float(sum[0] / n), float(sum[1] / n), float(sum[2] / n)};
}

Texture Texture::changed(const std::function<Rgb(const Rgb&)>& change, MemoryBudget& memory) const {
    Texture result = *this;
    if (kind_ == Kind::Constant) {
        result.constant_ = change(constant_);
    } else if (kind_ == Kind::Choice) {
        result.first_ = std::make_shared<const Texture>(first_->changed(change, memory));
        result.second_ = std::make_shared<const Texture>(second_->changed(change, memory));
    } else if (kind_ == Kind::Noise) {
        for (Rgb& color : result.noise_->colors) color = change(color);
    } else if (kind_ == Kind::Combination) {
        throw Error(
            "{}: a function of two textures that are mapped to the surface in different ways is not "
            "supported "
            "(the other at {})",
            first_->where_.str(), second_->where_.str());
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

Texture Texture::combined(const Texture& a, const Texture& b, Operation operation, MemoryBudget& memory) {
    const auto f = [operation](const Rgb& x, const Rgb& y) {
        return operation == Operation::Product ? x * y : x + y;
    };
    if (a.kind_ == Kind::Combination || b.kind_ == Kind::Combination) return later(a, b, operation);
    if (b.isConstant()) return a.changed([&](const Rgb& x) { return f(x, b.constant_); }, memory);
    if (a.isConstant()) return b.changed([&](const Rgb& x) { return f(a.constant_, x); }, memory);
    for (const Texture* choice : {&a, &b}) {
        if (choice->kind_ != Kind::Choice) continue;
        const Texture& other = choice == &a ? b : a;
        return Texture::choice(choice->choice_.c_str(), combined(*choice->first_, other, operation, memory),
                               combined(*choice->second_, other, operation, memory), choice->mapping_,
                               choice->where_);
    }
    if (a.kind_ == Kind::Noise || b.kind_ == Kind::Noise || !(a.mapping_ == b.mapping_) ||
        a.image_.wrap != b.image_.wrap)
        return later(a, b, operation);
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

/// What is looked up by uv, by those of its own mapping.
ElementPtr Texture::mapped(ElementPtr nested) const {
    if (mapping_.kind == "uv") return nested;
    return Maker("texture", "mapped", where_)
        .with("mapping", mapping_.kind)
        .with("to_texture", mapping_.toTexture)
        .containing(std::move(nested))
        .done();
}

ElementPtr Texture::choiceElement(bool asNumber) const {
    if (choice_ != "squares") {
        Maker result("texture", "cells", where_);
        result.with("kind", choice_);
        result.with("to_texture", choice_ == "cubes" ? mapping_.toTexture : mapping_.toUv);
        first_->addTo(result, "first", asNumber);
        second_->addTo(result, "second", asNumber);
        return choice_ == "cubes" ? result.done() : mapped(result.done());
    }
    Maker result("texture", "checkerboard", where_);
    // Ours has two squares in the unit of uv, and exchanges its colors where it gives numbers.
    const Transform half = mitsuba::settledMap(Transform::scale({0.5f, 0.5f, 1}) * mapping_.toUv);
    result.with("to_uv", half);
    first_->addTo(result, asNumber ? "color1" : "color0", asNumber);
    second_->addTo(result, asNumber ? "color0" : "color1", asNumber);
    return mapped(result.done());
}

ElementPtr Texture::element(bool asNumber) const {
    if (kind_ == Kind::Choice) return choiceElement(asNumber);
    if (kind_ == Kind::Combination) {
        Maker result("texture", "combination", where_);
        result.with("kind", std::string(operation_ == Operation::Product ? "product" : "sum"));
        first_->addTo(result, "first", asNumber);
        second_->addTo(result, "second", asNumber);
        return result.done();
    }
    if (kind_ == Kind::Noise) {
        auto colors = std::make_shared<std::vector<float>>();
        for (const Rgb& c : noise_->colors) colors->insert(colors->end(), {c.x, c.y, c.z});
        auto result = std::make_shared<mitsuba::Element>(*noise_->element);
        result->named.emplace_back(
            "data",
            mitsuba::Property{PixelArray{static_cast<int>(noise_->colors.size()), 1, 3, *colors, colors},
                              where_, false, static_cast<int>(result->named.size())});
        return result;
    }
    return mapped(Maker("texture", "bitmap", where_)
                      .with("data", PixelArray{image_.width, image_.height, 3, *image_.pixels, image_.pixels})
                      .with("raw", true)
                      .with("to_uv", mapping_.toUv)
                      .with("wrap_mode", image_.wrap)
                      .with("filter_type", std::string(image_.nearest ? "nearest" : "bilinear"))
                      .done());
}

}  // namespace metrolux::core::pbrt
