#include "io/gltf/materials.h"

#include "io/mitsuba/maker.h"

#include <array>

namespace metrolux::core::gltf {
namespace {

using namespace mitsuba;

constexpr const char* kTransmission = "KHR_materials_transmission";
constexpr const char* kDispersion = "KHR_materials_dispersion";
constexpr const char* kVolume = "KHR_materials_volume";
constexpr const char* kClearcoat = "KHR_materials_clearcoat";
constexpr const char* kSpecular = "KHR_materials_specular";
constexpr const char* kGlossiness = "KHR_materials_pbrSpecularGlossiness";
constexpr const char* kUnlit = "KHR_materials_unlit";

Location locationOf(const Node& node) { return {node.file(), 0, node.path()}; }

Rgb color(const std::vector<double>& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

bool isPresent(const Node& extension) { return !extension.json().empty(); }

/// Index of refraction with which KHR_materials_specular's factor at normal incidence is met.
double indexOf(const Node& material) {
    const double ior = material.extension("KHR_materials_ior").number("ior", 1.5);
    const Node specular = material.extension(kSpecular);
    if (!isPresent(specular)) return ior;
    const Rgb tint = color(specular.numbers("specularColorFactor", {1, 1, 1}));
    const double strength = specular.number("specularFactor", 1) * double(luminance(tint));
    const double f0 = std::min(sqr((ior - 1) / (ior + 1)) * strength, 0.98);
    return (1 + std::sqrt(f0)) / (1 - std::sqrt(f0));
}

/// uv' = offset + rotation * scale * uv, as KHR_texture_transform has it.
std::optional<core::Transform> toUv(const Node& info) {
    const Node t = info.extension("KHR_texture_transform");
    if (!isPresent(t)) return std::nullopt;
    const auto offset = t.numbers("offset", {0, 0}), scale = t.numbers("scale", {1, 1});
    const double angle = t.number("rotation", 0), c = std::cos(angle), s = std::sin(angle);
    return core::Transform::fromRows({{c * scale[0], s * scale[1], 0, offset[0]},
                                      {-s * scale[0], c * scale[1], 0, offset[1]},
                                      {0, 0, 1, 0},
                                      {0, 0, 0, 1}});
}

}  // namespace

Node Materials::node(int64_t material) const {
    if (material < 0) return document_.root().at("default material");  // which is not there
    return document_.element("materials", static_cast<size_t>(material));
}

Rgb Materials::baseColorFactor(int64_t material) const {
    return color(node(material).at("pbrMetallicRoughness").numbers("baseColorFactor", {1, 1, 1, 1}));
}

const ImageData& Materials::image(size_t index, bool raw) {
    const auto [entry, isNew] = images_.try_emplace({index, raw});
    if (isNew) entry->second = document_.image(index, raw);
    return entry->second;
}

template <class Pixel>
ElementPtr Materials::texture(const Node& info, bool raw, int channels, const Pixel& pixel) {
    if (!info.has("index")) return nullptr;
    const Node node = document_.element("textures", static_cast<size_t>(info.index("index")));
    if (!node.has("source")) {
        warn(node, "has no image of a kind that is read: it is left out");
        return nullptr;
    }
    const int64_t set = info.extension("KHR_texture_transform").has("texCoord")
                            ? info.extension("KHR_texture_transform").index("texCoord")
                            : info.index("texCoord");
    if (set > 0) warn(info, fmt::format("TEXCOORD_{} is not read: TEXCOORD_0 stands in", set));
    const ImageData& source = image(static_cast<size_t>(node.index("source")), raw);
    // Any number of materials may show one image.
    const auto texels = static_cast<uint64_t>(source.width) * static_cast<uint64_t>(source.height);
    memory_.take(texels * static_cast<uint64_t>(channels) * sizeof(float), "the texture");
    auto pixels = std::make_shared<std::vector<float>>();
    const auto own = static_cast<size_t>(source.channels);
    for (size_t i = 0; i + own <= source.pixels.size(); i += own) {
        const float* p = &source.pixels[i];
        const bool isGray = own < 3;
        const std::array<float, 4> rgba{p[0], isGray ? p[0] : p[1], isGray ? p[0] : p[2],
                                        own % 2 == 0 ? p[own - 1] : 1.0f};
        std::array<float, 3> out{};
        pixel(rgba, out);
        pixels->insert(pixels->end(), out.begin(), out.begin() + channels);
    }
    Maker bitmap("texture", "bitmap", locationOf(node));
    bitmap.with("data", PixelArray{source.width, source.height, channels, *pixels, pixels}).with("raw", true);
    if (const auto map = toUv(info)) bitmap.with("to_uv", *map);
    if (node.has("sampler")) {
        const Node sampler = document_.element("samplers", static_cast<size_t>(node.index("sampler")));
        const auto mode = [&](const char* key) {
            const int64_t code = sampler.index(key);
            return std::string(code == 33071 ? "clamp" : code == 33648 ? "mirror" : "repeat");
        };
        if (mode("wrapS") != mode("wrapT"))
            warn(sampler, "wraps differently in both directions: that of S holds for both");
        bitmap.with("wrap_mode", mode("wrapS"));
        if (sampler.index("magFilter") == 9728) bitmap.with("filter_type", std::string("nearest"));
    }
    return bitmap.done();
}

ElementPtr Materials::bsdf(int64_t material, bool colored) {
    const auto [entry, isNew] = bsdfs_.try_emplace({material, colored});
    if (isNew) entry->second = makeBsdf(node(material), colored);
    return entry->second;
}

ElementPtr Materials::makeBsdf(const Node& material, bool colored) {
    for (const char* left : {"KHR_materials_sheen", "KHR_materials_anisotropy", "KHR_materials_iridescence",
                             "KHR_materials_diffuse_transmission"})
        if (isPresent(material.extension(left)))
            warn(material, fmt::format("{} is not supported: it is left out", left));
    const bool transmits = material.extension(kTransmission).number("transmissionFactor", 0) > 0;
    ElementPtr result = bent(material, surface(material, colored));
    // Nothing is culled: surfaces that do not transmit look the same from both sides.
    if (!transmits)
        result = Maker("bsdf", "twosided", locationOf(material)).containing(std::move(result)).done();
    return masked(material, std::move(result));
}

ElementPtr Materials::surface(const Node& material, bool colored) {
    if (material.json().contains("extensions") && material.at("extensions").has(kUnlit))
        return Maker("bsdf", "diffuse", locationOf(material)).with("reflectance", RgbValue{Rgb(0.0f)}).done();
    Node pbr = material.at("pbrMetallicRoughness");
    const Node glossiness = material.extension(kGlossiness);
    const bool isGlossiness = isPresent(glossiness);
    if (isGlossiness) {
        warn(material, "KHR_materials_pbrSpecularGlossiness is read as its diffuse color and its roughness");
        pbr = glossiness;
    }
    const Rgb factor =
        colored ? Rgb(1.0f)
                : color(pbr.numbers(isGlossiness ? "diffuseFactor" : "baseColorFactor", {1, 1, 1, 1}));
    const double metallic = isGlossiness ? 0 : pbr.number("metallicFactor", 1);
    const double roughness =
        isGlossiness ? 1 - pbr.number("glossinessFactor", 1) : pbr.number("roughnessFactor", 1);
    const Node transmission = material.extension(kTransmission), volume = material.extension(kVolume);
    const double transmitted = transmission.number("transmissionFactor", 0);
    const bool isThin = transmitted > 0 && !(volume.number("thicknessFactor", 0) > 0);
    if (isThin && volume.has("attenuationDistance"))
        warn(material, "KHR_materials_volume absorbs nothing where \"thicknessFactor\" is zero");
    if (isThin && metallic > 0 && !pbr.has("metallicRoughnessTexture"))
        warn(material, "a thin surface that transmits has no metallic part: it is left out");

    Maker result("bsdf", isThin ? "principledthin" : "principled", locationOf(material));
    const Node colorInfo = pbr.at(isGlossiness ? "diffuseTexture" : "baseColorTexture");
    ElementPtr base = texture(colorInfo, false, 3, [&](const auto& in, auto& out) {
        for (size_t c = 0; c < 3; ++c) out[c] = std::clamp(in[c] * factor[static_cast<int>(c)], 0.0f, 1.0f);
    });
    if (base && colored) warn(material, "colors of vertices besides a texture of colors are left out");
    if (!base && colored)
        base = Maker("texture", "mesh_attribute", locationOf(material))
                   .with("name", std::string("vertex_color"))
                   .done();
    if (base)
        result.with("base_color", base);
    else
        result.with("base_color", RgbValue{factor});

    const Node mixed = pbr.at("metallicRoughnessTexture");
    const auto scalar = [&](const char* name, const Node& info, size_t channel, double by) {
        const ElementPtr map = texture(info, true, 1, [&](const auto& in, auto& out) {
            out[0] = std::clamp(in[channel] * static_cast<float>(by), 0.0f, 1.0f);
        });
        if (map)
            result.with(name, map);
        else
            result.with(name, by);
    };
    scalar("roughness", mixed, 1, roughness);
    if (!isThin) scalar("metallic", mixed, 2, metallic);
    if (transmitted > 0) scalar("spec_trans", transmission.at("transmissionTexture"), 0, transmitted);
    result.with("eta", indexOf(material));
    if (const double dispersion = material.extension(kDispersion).number("dispersion", 0); dispersion != 0) {
        if (!(dispersion > 0))
            throw material.error(
                fmt::format("found \"dispersion\" {}, expected a number that is not negative", dispersion));
        if (isThin || !(transmitted > 0))
            warn(material, "KHR_materials_dispersion has no effect where nothing refracts");
        else
            result.with("abbe", 20 / dispersion);
    }
    if (const Node coat = material.extension(kClearcoat); isPresent(coat)) {
        warn(material, "KHR_materials_clearcoat is read as the coat of the principled model, the nearest");
        if (!isThin) {
            scalar("clearcoat", coat.at("clearcoatTexture"), 0, coat.number("clearcoatFactor", 0));
            result.with("clearcoat_gloss", 1 - coat.number("clearcoatRoughnessFactor", 0));
        }
    }
    if (material.extension(kSpecular).has("specularColorFactor"))
        warn(material, "the tint of KHR_materials_specular is left out, its luminance holds");
    return result.done();
}

ElementPtr Materials::bent(const Node& material, ElementPtr nested) {
    const Node info = material.at("normalTexture");
    const float scale = static_cast<float>(info.number("scale", 1));
    ElementPtr map = texture(info, true, 3, [&](const auto& in, auto& out) {
        const Vec3f n = normalize(Vec3f((2 * in[0] - 1) * scale, (2 * in[1] - 1) * scale, 2 * in[2] - 1));
        for (size_t c = 0; c < 3; ++c) out[c] = 0.5f + 0.5f * n[static_cast<int>(c)];
    });
    if (!map) return nested;
    return Maker("bsdf", "normalmap", locationOf(material))
        .with("normalmap", map)
        .containing(std::move(nested))
        .done();
}

ElementPtr Materials::masked(const Node& material, ElementPtr nested) {
    const std::string mode = material.string("alphaMode", "OPAQUE");
    if (mode == "OPAQUE") return nested;
    if (mode != "MASK" && mode != "BLEND")
        throw material.error(fmt::format("found the alphaMode \"{}\", expected OPAQUE, MASK or BLEND", mode));
    const Node pbr = material.at("pbrMetallicRoughness");
    const auto factor = static_cast<float>(pbr.numbers("baseColorFactor", {1, 1, 1, 1})[3]);
    const auto cutoff = static_cast<float>(material.number("alphaCutoff", 0.5));
    const auto opacity = [&](float alpha) {
        if (mode == "MASK") return alpha * factor >= cutoff ? 1.0f : 0.0f;
        return std::clamp(alpha * factor, 0.0f, 1.0f);
    };
    const ElementPtr map = texture(pbr.at("baseColorTexture"), false, 1,
                                   [&](const auto& in, auto& out) { out[0] = opacity(in[3]); });
    Maker result("bsdf", "mask", locationOf(material));
    if (map)
        result.with("opacity", map);
    else
        result.with("opacity", static_cast<double>(opacity(1)));
    return result.containing(std::move(nested)).done();
}

ElementPtr Materials::interior(int64_t index) {
    if (index < 0) return nullptr;
    const auto [entry, isNew] = interiors_.try_emplace(index);
    if (!isNew) return entry->second;
    const Node material = node(index), volume = material.extension(kVolume);
    const bool transmits = material.extension(kTransmission).number("transmissionFactor", 0) > 0;
    if (!transmits || !(volume.number("thicknessFactor", 0) > 0) || !volume.has("attenuationDistance"))
        return nullptr;
    const double distance = volume.number("attenuationDistance", 0);
    if (!(distance > 0))
        throw volume.error(
            fmt::format("found \"attenuationDistance\" {}, expected more than zero", distance));
    const auto passing = volume.numbers("attenuationColor", {1, 1, 1});
    Rgb extinction;
    for (size_t c = 0; c < 3; ++c) {
        if (!(passing[c] >= 0 && passing[c] <= 1))
            throw volume.error(
                fmt::format("found \"attenuationColor\" with {}, expected numbers in [0, 1]", passing[c]));
        constexpr double kBlack = 1e-6;  // nothing is without any light
        extinction[static_cast<int>(c)] =
            static_cast<float>(-std::log(std::max(passing[c], kBlack)) / distance);
    }
    if (isBlack(extinction)) return nullptr;
    entry->second = Maker("medium", "homogeneous", locationOf(material))
                        .with("sigma_t", RgbValue{extinction})
                        .with("albedo", 0.0)
                        .done();
    return entry->second;
}

ElementPtr Materials::emitter(int64_t index) {
    if (index < 0) return nullptr;
    const Node material = node(index);
    const bool isUnlit = material.at("extensions").has(kUnlit);
    const Node pbr = material.at("pbrMetallicRoughness");
    const double strength =
        material.extension("KHR_materials_emissive_strength").number("emissiveStrength", 1);
    const Rgb factor =
        isUnlit ? baseColorFactor(index)
                : color(material.numbers("emissiveFactor", {0, 0, 0})) * static_cast<float>(strength);
    if (isBlack(factor)) return nullptr;
    if (isUnlit) warn(material, "KHR_materials_unlit is read as a light of its color, on the front only");
    const ElementPtr map = texture(isUnlit ? pbr.at("baseColorTexture") : material.at("emissiveTexture"),
                                   false, 3, [&](const auto& in, auto& out) {
                                       for (size_t c = 0; c < 3; ++c)
                                           out[c] = in[c] * factor[static_cast<int>(c)];
                                   });
    Maker result("emitter", "area", locationOf(material));
    if (map)
        result.with("radiance", map);
    else
        result.with("radiance", RgbValue{factor});
    return result.done();
}

}  // namespace metrolux::core::gltf
