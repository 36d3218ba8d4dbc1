#include "io/mitsuba/pattern_textures.h"

#include "io/mitsuba/choice.h"
#include "io/mitsuba/world_origin.h"
#include "scattering/textures/positional.h"

namespace metrolux::core::mitsuba {
namespace {

/// From the scene, which may have been moved to the origin.
Transform toTexture(const Element& e, const LoadContext& context) {
    return e.transform("to_texture", true) * Transform::translate(context.sceneOrigin);
}

TexturePtr mapped(const Element& e, LoadContext& context) {
    MappedTextureParameters p;
    p.mapping = choice<UvMapping>(e, "mapping",
                                  {{"planar", UvMapping::Planar},
                                   {"spherical", UvMapping::Spherical},
                                   {"cylindrical", UvMapping::Cylindrical}});
    p.toTexture = toTexture(e, context);
    const std::vector<ElementPtr> nested = e.childrenOf("texture");
    if (nested.size() != 1)
        throw e.error(fmt::format("found {} nested <texture> elements, expected one", nested.size()));
    p.texture = makeTexture(*nested[0], context);
    return makeMappedTexture(p);
}

TexturePtr noise(const Element& e, LoadContext& context) {
    using Kind = NoiseTextureParameters::Kind;
    NoiseTextureParameters p;
    p.kind = choice<Kind>(e, "kind",
                          {{"fractal", Kind::Fractal},
                           {"turbulence", Kind::Turbulence},
                           {"windy", Kind::Windy},
                           {"marble", Kind::Marble}});
    p.toTexture = toTexture(e, context);
    const int64_t octaves = e.integer("octaves", p.octaves);
    p.octaves = static_cast<int>(std::clamp<int64_t>(octaves, 0, 1000));
    p.roughness = e.number("roughness", p.roughness);
    p.scale = e.number("scale", p.scale);
    p.variation = e.number("variation", p.variation);
    p.low = e.number("low", p.low);
    p.high = e.number("high", p.high);
    const ImageData colors = context.image(e, true);
    for (int x = 0; x < colors.width; ++x) {
        const float* v = colors.at(x, 0);
        p.colors.push_back(colors.channels >= 3 ? Rgb(v[0], v[1], v[2]) : Rgb(v[0]));
    }
    return makeNoiseTexture(p);
}

TexturePtr cells(const Element& e, LoadContext& context) {
    using Kind = CellsParameters::Kind;
    CellsParameters p;
    p.kind = choice<Kind>(e, "kind", {{"cubes", Kind::Cubes}, {"discs", Kind::Discs}});
    p.toTexture = p.kind == Kind::Cubes ? toTexture(e, context) : e.transform("to_texture", true);
    p.first = patternColor(e, "first", 1, context, false);
    p.second = patternColor(e, "second", 0, context, false);
    return makeCells(p);
}

TexturePtr combination(const Element& e, LoadContext& context) {
    using Kind = CombinationParameters::Kind;
    CombinationParameters p;
    p.kind = choice<Kind>(e, "kind", {{"product", Kind::Product}, {"sum", Kind::Sum}});
    p.first = patternColor(e, "first", 1, context, false);
    p.second = patternColor(e, "second", 1, context, false);
    return makeCombination(p);
}

}  // namespace

const std::vector<std::string>& patternTextureNames() {
    static const std::vector<std::string> names = {"mapped", "noise", "cells", "combination"};
    return names;
}

TexturePtr makePatternTexture(const Element& element, LoadContext& context) {
    return withLocation(element, [&] {
        if (element.type == "mapped") return mapped(element, context);
        if (element.type == "noise") return noise(element, context);
        if (element.type == "cells") return cells(element, context);
        if (element.type == "combination") return combination(element, context);
        throw Error("unknown pattern");
    });
}

}  // namespace metrolux::core::mitsuba
