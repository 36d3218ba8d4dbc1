#include "io/mitsuba/context.h"

namespace metrolux::core::mitsuba {
namespace {

int depthProperty(const Element& element, const std::string& name, int fallback, int64_t least) {
    const int64_t value = element.integer(name, fallback);
    if (value == -1 || (value >= least && value <= std::numeric_limits<int>::max()))
        return static_cast<int>(value);
    throw element.error(*element.find(name),
                        fmt::format("found {}, expected -1 or {} and more", value, least));
}

/// Numbers, texts and truth values are all that a setting can be.
ParameterValue valueOf(const Property& property) {
    if (const auto* v = std::get_if<bool>(&property.value)) return *v;
    if (const auto* v = std::get_if<int64_t>(&property.value)) return *v;
    if (const auto* v = std::get_if<double>(&property.value)) return *v;
    if (const auto* v = std::get_if<std::string>(&property.value)) return *v;
    return std::string("neither number nor text");
}

/// How messages about it begin.
std::string placeOf(const Error& emptyMessage) {
    const std::string text = emptyMessage.what();
    return text.substr(0, text.rfind(": "));
}

/// An integrator around another one (aov, moment, irrcache ...): the inner one renders.
void readNested(const Element& element, const std::vector<ElementPtr>& nested, LoadContext& context,
                SceneParts& parts) {
    std::string unused;
    for (const auto& [name, property] : element.named) {
        if (property.used) continue;
        property.used = true;
        unused += fmt::format("{}\"{}\"", unused.empty() ? "" : ", ", name);
    }
    if (!unused.empty()) context.warn(element, "no effect here: " + unused);
    if (nested.size() > 1)
        context.warn(element, fmt::format("uses the first of its {} nested integrators", nested.size()));
    readIntegrator(*nested.front(), context, parts);
}

}  // namespace

void readIntegrator(const Element& element, LoadContext& context, SceneParts& parts) {
    const std::vector<ElementPtr> nested = element.childrenOf("integrator");
    if (!nested.empty()) {
        readNested(element, nested, context, parts);
    } else {
        const bool direct = element.type == "direct";
        if (direct && element.isLegacy()) {
            element.ignore("max_depth");
            element.ignore("rr_depth");
        }
        parts.limits.maxDepth = direct ? 2 : depthProperty(element, "max_depth", -1, 0);
        const int roulette = direct ? 5 : depthProperty(element, "rr_depth", 5, 1);
        parts.limits.rouletteDepth = roulette == -1 ? std::numeric_limits<int>::max() : roulette;
        parts.limits.hideEmitters = element.boolean("hide_emitters", false);
        parts.integrator = {element.type, placeOf(element.error("")), {}, element.isLegacy()};
        for (const auto& [name, property] : element.named) {
            if (property.used || (direct && (name == "max_depth" || name == "rr_depth"))) continue;
            property.used = true;
            parts.integrator.settings.push_back(
                {name, valueOf(property), placeOf(element.error(property, ""))});
        }
    }
    element.checkAllUsed(context.lenient, context.warnings);
}

}  // namespace metrolux::core::mitsuba
