#include "io/mitsuba/bsdf_source.h"

namespace metrolux::core::mitsuba {

float BsdfSource::ior(const std::string& name, const std::string& fallback) const {
    const Property* property = element.find(name);
    if (property && !std::holds_alternative<std::string>(property->value)) {
        const float value = element.number(name, 0);
        if (!(value > 0))
            throw element.error(*property,
                                fmt::format("found {}, expected a positive index of refraction", value));
        return value;
    }
    const std::string material = element.string(name, fallback);
    if (const auto value = namedIor(material)) return *value;
    throw element.error(*property, fmt::format("found the material \"{}\", expected a number or one of: {}",
                                               material, fmt::join(iorNames(), ", ")));
}

MicrofacetType BsdfSource::distribution() const {
    element.ignore("sample_visible");  // always
    const std::string name = element.string("distribution", "beckmann");
    if (name == "beckmann") return MicrofacetType::Beckmann;
    if (name == "ggx") return MicrofacetType::Ggx;
    if (element.isLegacy() && (name == "phong" || name == "as")) {
        context.warn(element, fmt::format("the distribution \"{}\" of 0.6 is read as beckmann", name));
        return MicrofacetType::Beckmann;
    }
    throw element.error(fmt::format("found the distribution \"{}\", expected beckmann or ggx", name));
}

std::vector<BsdfPtr> BsdfSource::nested(size_t least, size_t most) const {
    const std::vector<ElementPtr> children = element.childrenOf("bsdf");
    if (children.size() < least || children.size() > most)
        throw element.error(
            fmt::format("found {} nested <bsdf> elements, expected {}", children.size(),
                        least == most ? std::to_string(least) : fmt::format("{} to {}", least, most)));
    std::vector<BsdfPtr> result;
    for (const ElementPtr& child : children) result.push_back(makeBsdf(*child, context));
    return result;
}

TexturePtr BsdfSource::nestedTexture(const std::string& name) const {
    if (const ElementPtr child = element.child(name)) return makeTexture(*child, context);
    if (!name.empty() && element.has(name)) return textureProperty(element, name, context, Rgb(0.0f));
    const std::vector<ElementPtr> children = element.childrenOf("texture");
    if (children.size() != 1)
        throw element.error(fmt::format("found {} nested <texture> elements, expected one", children.size()));
    return makeTexture(*children[0], context);
}

}  // namespace metrolux::core::mitsuba
