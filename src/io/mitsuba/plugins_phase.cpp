/// Phase functions: Mitsuba 3's, and the mixtures of 0.6.

#include "io/mitsuba/media.h"
#include "io/mitsuba/unknown_plugins.h"
#include "io/mitsuba/values.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

Scatterer isotropic(const Element&, LoadContext&) { return {makeIsotropicPhase()}; }
Scatterer rayleigh(const Element&, LoadContext&) { return {makeRayleighPhase()}; }
Scatterer henyeyGreenstein(const Element& e, LoadContext&) {
    return {makeHenyeyGreensteinPhase(e.number("g", 0.8f))};
}

std::vector<double> numbers(const Element& e, const char* name) {
    const std::string text = e.requiredString(name);
    try {
        return parseNumberList(text);
    } catch (const Error& problem) {
        throw e.error(*e.find(name), problem.what());
    }
}

Scatterer tabulated(const Element& e, LoadContext&) {
    std::vector<float> values;
    for (const double value : numbers(e, "values")) values.push_back(static_cast<float>(value));
    return {makeTabulatedPhase(values)};
}

std::vector<NamedChild> nested(const Element& e, size_t least, size_t most) {
    std::vector<NamedChild> result = e.namedChildrenOf("phase");
    if (result.size() < least || result.size() > most)
        throw e.error(
            fmt::format("found {} nested <phase> elements, expected {}", result.size(),
                        least == most ? std::to_string(least) : fmt::format("{} to {}", least, most)));
    return result;
}

/// Which is which is decided by their names, those without one come first.
Scatterer blend(const Element& e, LoadContext& context) {
    std::vector<NamedChild> parts = nested(e, 2, 2);
    std::stable_sort(parts.begin(), parts.end(),
                     [](const NamedChild& a, const NamedChild& b) { return a.name < b.name; });
    const Scatterer first = makePhase(*parts[0].element, context),
                    second = makePhase(*parts[1].element, context);
    const Quantity weight{"weight in [0, 1]", kAlbedo.convert, 1};
    return {
        makeBlendPhase(first.phase, second.phase, volumeProperty(e, "weight", context, weight, 0.5f, false))};
}

/// 0.6: weights as one text; what they leave of one is absorbed.
Scatterer mixture(const Element& e, LoadContext& context) {
    const std::vector<NamedChild> parts = nested(e, 1, 64);
    const std::vector<double> weights = numbers(e, "weights");
    if (weights.size() != parts.size())
        throw e.error(*e.find("weights"),
                      fmt::format("found {} weights for {} nested <phase> elements, expected as many",
                                  weights.size(), parts.size()));
    double sum = 0;
    for (const double w : weights) {
        if (!(w >= 0))
            throw e.error(*e.find("weights"), fmt::format("found {}, expected weights of zero or more", w));
        sum += w;
    }
    if (!(sum > 0)) throw e.error(*e.find("weights"), "the weights sum to zero, expected more");
    if (sum > 1) context.warn(e, fmt::format("the sum of the weights, {:.3g}, is scaled to 1", sum));
    Scatterer result;
    double mixed = 0;  // share of `result`
    for (size_t i = 0; i < parts.size(); ++i) {
        const Scatterer part = makePhase(*parts[i].element, context);
        const double share = weights[i] / std::max(sum, 1.0) * double(part.albedo);
        mixed += share;
        if (!result.phase)
            result.phase = part.phase;
        else if (share > 0)
            result.phase = makeBlendPhase(result.phase, part.phase,
                                          makeConstantVolume(Rgb(static_cast<float>(share / mixed))));
    }
    result.albedo = static_cast<float>(mixed);
    return result;
}

using PhaseFactory = Scatterer (*)(const Element&, LoadContext&);
struct PhasePlugin {
    const char* type;
    PhaseFactory make;
};
constexpr PhasePlugin kPhasePlugins[] = {{"isotropic", isotropic}, {"hg", henyeyGreenstein},
                                         {"rayleigh", rayleigh},   {"tabphase", tabulated},
                                         {"blendphase", blend},    {"mixturephase", mixture}};

}  // namespace

std::vector<std::string> phaseTypes() {
    std::vector<std::string> names;
    for (const PhasePlugin& plugin : kPhasePlugins) names.emplace_back(plugin.type);
    return names;
}

Scatterer makePhase(const Element& element, LoadContext& context) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return *std::static_pointer_cast<const Scatterer>(found->second);
    Scatterer result;
    for (const PhasePlugin& plugin : kPhasePlugins)
        if (element.type == plugin.type)
            result = withLocation(element, [&] { return plugin.make(element, context); });
    if (result.phase) {
        element.checkAllUsed(context.lenient, context.warnings);
    } else {
        const std::string message = unknownPlugin(element, "phase function", phaseTypes());
        if (!context.lenient) throw element.error(message);
        context.warn(element, message + " (isotropic stands in)");
        result = {makeIsotropicPhase()};
    }
    context.built[&element] = std::make_shared<const Scatterer>(result);
    return result;
}

}  // namespace metrolux::core::mitsuba
