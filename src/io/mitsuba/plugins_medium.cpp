/// Media: Mitsuba 3's plugins, and what 0.6 has in addition.

#include "io/medium_presets.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/unknown_plugins.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

Scatterer scattererOf(const Element& e, LoadContext& context) {
    const std::vector<ElementPtr> phases = e.childrenOf("phase");
    if (phases.size() > 1)
        throw e.error(fmt::format("found {} phase functions, expected one at most", phases.size()));
    return phases.empty() ? Scatterer{makeIsotropicPhase()} : makePhase(*phases[0], context);
}

void refuseEmission(const Element& e) {
    bool emits = !e.childrenOf("emitter").empty();
    for (const char* name : {"emission", "radiance"}) emits = emits || e.has(name);
    if (emits) throw e.error("emissive media are not supported, expected one that absorbs and scatters");
}

float scaleOf(const Element& e) {
    const char* name = "scale";
    if (e.isLegacy() && e.has("density_multiplier")) {  // its name before 0.4
        if (e.has(name)) throw e.error("found \"density_multiplier\" as well as \"scale\", expected one");
        name = "density_multiplier";
    }
    const float scale = e.number(name, 1);
    if (!(scale >= 0))
        throw e.error(*e.find(name), fmt::format("found {}, expected a scale of zero or more", scale));
    return scale;
}

/// What says how samples are spent, here or in Mitsuba.
void readSampling(const Element& e, LoadContext& context) {
    e.boolean("sample_emitters", true);
    e.boolean("has_spectral_extinction", true);
    for (const char* name :
         {"strategy", "medium_sampling_weight", "channel", "sampling_density", "method", "step_size"})
        if (e.isLegacy()) e.ignore(name);
    for (const auto& [name, property] : e.named)
        if (name.starts_with("majorant_") && !std::holds_alternative<ElementPtr>(property.value)) {
            e.ignore(name);
            context.warn(e, fmt::format("\"{}\" has no effect: it changes noise only", name));
        }
}

/// Extinction over scale, and albedo.
struct Coefficients {
    Rgb extinction{1.0f}, albedo{0.75f};
};

Coefficients fromParts(const Rgb& absorbed, const Rgb& scattered) {
    Coefficients result;
    result.extinction = absorbed + scattered;
    for (int c = 0; c < 3; ++c)
        result.albedo[c] = result.extinction[c] > 0 ? scattered[c] / result.extinction[c] : 0;
    return result;
}

/// 0.6: of a preset, or given in one of two pairs, of which the preset says what is missing.
Coefficients readLegacy(const Element& e, LoadContext& context) {
    const bool hasParts = e.has("sigma_s") || e.has("sigma_a"),
               hasWhole = e.has("sigma_t") || e.has("albedo"), hasPreset = e.has("material");
    if (hasPreset && (hasParts || hasWhole))
        throw e.error("found \"material\" as well as coefficients, expected one of the two");
    if (hasParts && hasWhole)
        throw e.error(
            "found \"sigmaT\" or \"albedo\" as well as \"sigmaS\" or \"sigmaA\", expected one of the pairs");
    const std::string name = e.string("material", "Skin1");
    const MediumPreset* const preset = findMediumPreset(kMitsubaPresets, name);
    if (!preset)
        throw e.error(*e.find("material"), fmt::format("found the material \"{}\", expected one of: {}", name,
                                                       mediumPresetNames(kMitsubaPresets)));
    if (!(e.has("sigma_s") && e.has("sigma_a")) && !(e.has("sigma_t") && e.has("albedo")))
        context.warn(e, fmt::format("the coefficients of \"{}\" are per millimeter, as documented; Mitsuba "
                                    "0.6 itself takes 100 times as much",
                                    preset->name));
    const auto given = [&](const char* property, const Quantity& kind, const Rgb& fallback) {
        return e.has(property) ? quantity(e, property, kind, 0) : fallback;
    };
    const Coefficients usual = fromParts(preset->absorption, preset->scattering);
    Coefficients result;
    if (hasWhole) {
        result = {given("sigma_t", kCoefficient, usual.extinction), given("albedo", kAlbedo, usual.albedo)};
    } else {
        result = fromParts(given("sigma_a", kCoefficient, preset->absorption),
                           given("sigma_s", kCoefficient, preset->scattering));
    }
    // The mean cosine reduces the scattering there, whatever the phase function.
    Rgb g = preset->meanCosine;
    if (const Property* property = e.find("g")) {
        const auto color = constantColor(e, *property, kCoefficient.convert);
        if (!color) throw e.error(*property, "found an element, expected a number or a color");
        g = *color;
        for (int c = 0; c < 3; ++c)
            if (!(g[c] > -1 && g[c] < 1))
                throw e.error(*property, fmt::format("found {}, expected a mean cosine in (-1, 1)", g[c]));
    }
    const Rgb scattered = result.extinction * result.albedo;
    return g == Rgb(0.0f) ? result : fromParts(result.extinction - scattered, scattered * (Rgb(1.0f) - g));
}

MediumPtr withVolumes(const Element& e, const VolumePtr& density, const VolumePtr& albedo, float scale,
                      const Scatterer& scatterer) {
    if (scatterer.albedo == 1) return makeHeterogeneousMedium(density, scale, albedo, scatterer.phase);
    if (!albedo->isConstant())
        throw e.error(
            "the weights of its phase function sum to less than one, expected one where the albedo varies");
    return makeHeterogeneousMedium(
        density, scale, makeConstantVolume(albedo->value(Vec3f(0.0f)) * scatterer.albedo), scatterer.phase);
}

MediumPtr homogeneous(const Element& e, LoadContext& context) {
    const Scatterer scatterer = scattererOf(e, context);
    const float scale = scaleOf(e);
    if (e.isLegacy()) {
        const Coefficients c = readLegacy(e, context);
        return makeHomogeneousMedium(c.extinction * scale, c.albedo * scatterer.albedo, scatterer.phase);
    }
    if (e.has("sigma_s") || e.has("sigma_a"))
        throw e.error(fmt::format(
            "found \"{}\"{}, expected \"sigma_t\" and \"albedo\"; sigma_s and sigma_a are of 0.x",
            e.has("sigma_s") ? "sigma_s" : "sigma_a", e.has("sigma_t") ? " as well as \"sigma_t\"" : ""));
    const VolumePtr extinction = volumeProperty(e, "sigma_t", context, kCoefficient, 1, false),
                    albedo = volumeProperty(e, "albedo", context, kAlbedo, 0.75f, false);
    if (!extinction->isConstant())
        throw e.error(*e.find("sigma_t"),
                      "found a volume that varies, expected a constant (or the type heterogeneous)");
    const Rgb sigma = extinction->value(Vec3f(0.0f));
    if (albedo->isConstant())
        return makeHomogeneousMedium(sigma * scale, albedo->value(Vec3f(0.0f)) * scatterer.albedo,
                                     scatterer.phase);
    return withVolumes(e, makeConstantVolume(sigma), albedo, scale, scatterer);
}

MediumPtr heterogeneous(const Element& e, LoadContext& context) {
    const Scatterer scatterer = scattererOf(e, context);
    const float scale = scaleOf(e);
    if (e.has("sigma_s") || e.has("sigma_a"))
        throw e.error(fmt::format("found \"{}\", expected volumes of the extinction and of the albedo",
                                  e.has("sigma_s") ? "sigma_s" : "sigma_a"));
    if (e.isLegacy()) {
        for (const char* name : {"density", "albedo"})
            if (!e.has(name)) throw e.error(fmt::format("has no \"{}\", expected a <volume>", name));
        if (e.child("orientation"))
            context.warn(e, "\"orientation\" has no effect: no phase function depends on it");
    }
    return withVolumes(
        e, volumeProperty(e, e.isLegacy() ? "density" : "sigma_t", context, kCoefficient, 1, !e.isLegacy()),
        volumeProperty(e, "albedo", context, kAlbedo, 0.75f, false), scale, scatterer);
}

using MediumFactory = MediumPtr (*)(const Element&, LoadContext&);
const std::vector<std::pair<std::string, MediumFactory>> kMediumFactories = {
    {"homogeneous", homogeneous}, {"heterogeneous", heterogeneous}};

}  // namespace

std::vector<std::string> mediumTypes() {
    std::vector<std::string> names;
    names.reserve(kMediumFactories.size());
    for (const auto& [name, factory] : kMediumFactories) names.push_back(name);
    return names;
}

MediumPtr makeMedium(const Element& element, LoadContext& context) {
    MediumPtr result;
    for (const auto& [name, factory] : kMediumFactories) {
        if (element.type != name) continue;
        refuseEmission(element);
        readSampling(element, context);
        result = withLocation(element, [&, make = factory] { return make(element, context); });
    }
    if (result) {
        element.checkAllUsed(context.lenient, context.warnings);
        return result;
    }
    const std::string message = unknownPlugin(element, "medium", mediumTypes());
    if (!context.lenient) throw element.error(message);
    context.warn(element, message + " (it is left out)");
    return nullptr;
}

MediumIndex addMedium(const Element& element, LoadContext& context) {
    constexpr size_t kMost = std::numeric_limits<MediumIndex>::max();
    if (context.media.size() >= kMost)
        throw element.error(fmt::format("found more than {} media, expected as many at most", kMost));
    MediumPtr medium = makeMedium(element, context);
    if (!medium) return 0;
    context.media.push_back(std::move(medium));
    return static_cast<MediumIndex>(context.media.size());
}

MediumIndex mediumIndex(const Element& element, LoadContext& context) {
    if (const auto found = context.mediumIndices.find(&element); found != context.mediumIndices.end())
        return found->second;
    return context.mediumIndices[&element] = addMedium(element, context);
}

std::optional<MediumIndex> mediumOf(const Element& element, LoadContext& context) {
    const std::vector<ElementPtr> media = element.childrenOf("medium");
    if (media.size() > 1)
        throw element.error(fmt::format("found {} media, expected one at most", media.size()));
    if (media.empty()) return std::nullopt;
    return mediumIndex(*media[0], context);
}

std::optional<MediumSides> mediumSidesOf(const Element& element, LoadContext& context) {
    std::optional<MediumSides> sides;
    for (const NamedChild& child : element.namedChildrenOf("medium")) {
        const bool isInside = child.name == "interior";
        if (!isInside && child.name != "exterior")
            throw child.element->error(fmt::format(
                "found a medium {} in a <shape type=\"{}\">, expected the name interior or exterior",
                child.name.empty() ? "without a name" : fmt::format("with the name \"{}\"", child.name),
                element.type));
        if (!sides) sides.emplace();
        (isInside ? sides->interior : sides->exterior) = mediumIndex(*child.element, context);
    }
    return sides;
}

}  // namespace metrolux::core::mitsuba
