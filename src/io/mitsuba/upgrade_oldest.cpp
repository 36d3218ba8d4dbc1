#include "io/mitsuba/upgrade_oldest.h"

namespace metrolux::core::mitsuba {
namespace {

struct Renamed {
    const char *tag, *type;  ///< type: empty for all
    const char *from, *to;
};
/// Parameters that 0.3 and 0.4 have renamed.
constexpr Renamed kParameters03[] = {{"shape", "sphere", "inverted", "flipNormals"},
                                     {"shape", "cylinder", "p1", "p0"},  // before p2, which becomes p1
                                     {"shape", "cylinder", "p2", "p1"},
                                     {"texture", "checkerboard", "brightColor", "color0"},
                                     {"texture", "checkerboard", "darkColor", "color1"},
                                     {"bsdf", "ward", "alphaX", "alphaU"},
                                     {"bsdf", "ward", "alphaY", "alphaV"},
                                     {"bsdf", "", "alphaB", "alpha"},
                                     {"bsdf", "roughmetal", "ior", "eta"}};
constexpr Renamed kParameters04[] = {{"emitter", "area", "intensity", "radiance"},
                                     {"emitter", "constant", "intensity", "radiance"},
                                     {"emitter", "directional", "intensity", "irradiance"},
                                     {"emitter", "", "intensityScale", "scale"},
                                     {"sensor", "", "focusDepth", "focusDistance"},
                                     {"integrator", "", "luminaireSamples", "emitterSamples"}};
/// Plugins: `from` and `to` are types.
constexpr Renamed kTypes03[] = {
    {"bsdf", "", "lambertian", "diffuse"},         {"bsdf", "", "microfacet", "roughplastic"},
    {"bsdf", "", "mirror", "conductor"},           {"bsdf", "", "roughmetal", "roughconductor"},
    {"bsdf", "", "roughglass", "roughdielectric"}, {"bsdf", "", "composite", "mixturebsdf"},
    {"texture", "", "exrtexture", "bitmap"},       {"texture", "", "ldrtexture", "bitmap"}};
constexpr Renamed kTypes04[] = {{"film", "", "exrfilm", "hdrfilm"}, {"film", "", "pngfilm", "ldrfilm"}};

template <size_t N>
void renameParameters(Element& element, const Renamed (&list)[N]) {
    for (const Renamed& r : list) {
        if (element.tag != r.tag || (*r.type && element.type != r.type)) continue;
        for (auto& entry : element.named)
            if (entry.first == r.from) entry.first = r.to;
    }
}

template <size_t N>
void renameType(Element& element, const Renamed (&list)[N]) {
    for (const Renamed& r : list)
        if (element.tag == r.tag && element.type == r.from) {
            element.type = r.to;
            return;
        }
}

void addString(Element& element, const std::string& name, const std::string& value) {
    Property property;
    property.value = value;
    property.location = element.location;
    element.named.emplace_back(name, std::move(property));
}

/// Cameras looked along the same axis with the other hand, and their angle was that of the smaller side.
void camera(Element& element) {
    bool isLarger = false;
    std::erase_if(element.named, [&](const auto& entry) {
        if (entry.first != "mapSmallerSide") return false;
        const bool* isSmaller = std::get_if<bool>(&entry.second.value);
        isLarger = isSmaller && !*isSmaller;
        return true;
    });
    if (element.type == "perspective") addString(element, "fovAxis", isLarger ? "larger" : "smaller");
    for (auto& [name, property] : element.named)
        if (Transform* map = std::get_if<Transform>(&property.value); map && name == "toWorld")
            *map = *map * Transform::scale({-1, 1, 1});
}

}  // namespace

std::string tagOf04(const std::string& tag) {
    return tag == "camera" ? "sensor" : tag == "luminaire" ? "emitter" : tag;
}

void upgradeOldest(Element& element, int minor) {
    if (minor < 3) {
        if (element.type == "mirror") addString(element, "material", "Cr");
        renameParameters(element, kParameters03);
        renameType(element, kTypes03);
    }
    if (minor < 4) {
        renameParameters(element, kParameters04);
        renameType(element, kTypes04);
        if (element.tag == "sensor") camera(element);
        if (element.tag == "film")  // whether the file has an alpha channel
            std::erase_if(element.named, [](const auto& entry) { return entry.first == "alpha"; });
    }
    if (element.tag == "bsdf" && element.type == "bump") element.type = "bumpmap";
}

}  // namespace metrolux::core::mitsuba
