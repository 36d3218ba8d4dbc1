#include "io/pbrt/materials.h"

#include "base/suggest.h"
#include "io/mitsuba/maker.h"

#include <algorithm>

namespace metrolux::core::pbrt {

using mitsuba::ElementPtr;
using mitsuba::Maker;
using mitsuba::RgbValue;

/// What one material is made from.
struct MaterialMaker {
    Materials& all;
    const Parameters& p;
    const ColorSpace& space;

    Reading& reading() const { return all.reading_; }
    MemoryBudget& memory() const { return all.reading_.memory; }
    Texture color(const char* name, float fallback) const {
        return all.textures_.color(p, name, Rgb(fallback), space);
    }
    Texture number(const std::string& name, double fallback) const {
        return all.textures_.number(p, name, fallback);
    }
    double eta(const char* name, double fallback) const {
        return indexOfRefraction(p, name, fallback, reading());
    }

    /// Of glass in vacuum, with dispersion if pbrt's name says which glass.
    void addIndex(const char* name, Maker& result) const {
        if (const auto glass = namedGlass(p, name))
            result.with("glass", *glass);
        else
            result.with("int_ior", eta(name, 1.5));
        result.with("ext_ior", 1.0);
    }

    Maker element(const char* type) const { return {"bsdf", type, p.where()}; }
    ElementPtr twoSided(ElementPtr nested) const {
        return Maker("bsdf", "twosided", p.where()).containing(std::move(nested)).done();
    }

    /// pbrt's roughness as the width of GGX, or nothing where pbrt takes the surface for smooth.
    struct Roughness {
        Texture u, v;
        bool isSmooth;
    };
    Roughness roughness(const std::string& prefix, double fallback) const {
        constexpr float kSmooth = 1e-3f;
        const Texture both = number(prefix + "roughness", fallback);
        Texture u = p.has(prefix + "uroughness") ? number(prefix + "uroughness", 0) : both;
        Texture v = p.has(prefix + "vroughness") ? number(prefix + "vroughness", 0) : both;
        if (p.boolean("remaproughness", true)) {
            const auto root = [](const Rgb& x) { return Rgb(std::sqrt(std::max(x.x, 0.0f))); };
            u = u.changed(root, memory());
            v = v.changed(root, memory());
        }
        const bool isSmooth = std::max(u.largest().x, v.largest().x) < kSmooth;
        return {std::move(u), std::move(v), isSmooth};
    }
    /// The element of the smooth or of the rough model.
    Maker faceted(const char* smooth, const char* rough, const Roughness& r) const {
        if (r.isSmooth) return element(smooth);
        auto result = element(rough);
        result.with("distribution", std::string("ggx"));
        r.u.addTo(result, "alpha_u", true);
        r.v.addTo(result, "alpha_v", true);
        return result;
    }

    ElementPtr diffuse(const char* name, float fallback) const {
        auto result = element("diffuse");
        color(name, fallback).addTo(result, "reflectance", false);
        return twoSided(result.done());
    }

    /// A metal of this reflectance at normal incidence: eta 1, k = 2 sqrt(r / (1 - r)).
    static Rgb absorptionOf(const Rgb& reflectance) {
        Rgb k;
        for (int c = 0; c < 3; ++c) {
            const float r = std::clamp(reflectance[c], 0.0f, 0.9999f);
            k[c] = 2 * std::sqrt(r / (1 - r));
        }
        return k;
    }
    ElementPtr metal(const std::string& prefix, double roughnessFallback) const {
        auto result = faceted("conductor", "roughconductor", roughness(prefix, roughnessFallback));
        if (p.has("reflectance")) {
            if (p.has(prefix + "eta") || p.has(prefix + "k"))
                throw p.error("found \"reflectance\" as well as \"eta\" or \"k\", expected one of the two");
            result.with("eta", RgbValue{Rgb(1.0f)});
            color("reflectance", 1).changed(absorptionOf, memory()).addTo(result, "k", false);
        } else {
            const ConductorColors metal = conductorColors(p, prefix, space, reading());
            result.with("eta", RgbValue{metal.eta});
            result.with("k", RgbValue{metal.k});
        }
        return result.done();
    }

    /// A diffuse surface under a smooth or rough dielectric coat, all orders of reflection between them.
    ElementPtr coatedDiffuse(const char* reflectance, double roughnessFallback) const {
        const Roughness r = roughness("", roughnessFallback);
        auto result = element(r.isSmooth ? "plastic" : "roughplastic");
        if (!r.isSmooth) {
            result.with("distribution", std::string("ggx"));
            const double alpha = double((r.u.mean().x + r.v.mean().x) / 2);
            if (!r.u.isConstant() || !r.v.isConstant() || r.u.constant() != r.v.constant())
                reading().warn(p.error("a coat has one roughness here: the mean stands in"));
            result.with("alpha", alpha);
        }
        result.with("int_ior", eta("eta", 1.5));
        result.with("ext_ior", 1.0);
        result.with("nonlinear", true);
        color(reflectance, 0.5f).addTo(result, "diffuse_reflectance", false);
        if (number("albedo", 0).largest().x > 0)
            reading().refuse(p.error("a coat that scatters (\"albedo\") is not supported"),
                             "the coat is clear");
        p.ignore({"thickness", "g", "maxdepth", "nsamples"});
        return twoSided(result.done());
    }

    ElementPtr coatedConductor() const {
        reading().warn(
            p.error("coatedconductor is read as a metal under a coat that reflects once from each side, "
                    "the nearest model"));
        ElementPtr base = metal("conductor.", 0);
        const Roughness r = roughness("interface.", 0);
        auto result = element(r.isSmooth ? "coating" : "roughcoating");
        result.with("int_ior", eta("interface.eta", 1.5));
        result.with("ext_ior", 1.0);
        if (!r.isSmooth) {
            result.with("distribution", std::string("ggx"));
            result.with("alpha", double((r.u.mean().x + r.v.mean().x) / 2));
        }
        p.ignore({"thickness", "albedo", "g", "maxdepth", "nsamples"});
        result.containing(std::move(base));
        return twoSided(result.done());
    }

    ElementPtr glass(const char* etaName, double roughnessFallback) const {
        auto result = faceted("dielectric", "roughdielectric", roughness("", roughnessFallback));
        addIndex(etaName, result);
        return result.done();
    }
    ElementPtr thinGlass() const {
        auto result = element("thindielectric");
        addIndex("eta", result);
        return result.done();
    }

    /// Diffuse to both sides. The two lobes are blended in proportion to what they can scatter.
    ElementPtr diffuseTransmission(float fallback) const {
        const auto by = static_cast<float>(p.number("scale", 1));
        const auto maximum = [](const Texture& t) { return double(maxComponent(t.largest())); };
        const Texture reflected = color("reflectance", fallback),
                      transmitted = color("transmittance", fallback);
        const double r = maximum(reflected), t = maximum(transmitted);
        const double share = r + t > 0 ? t / (r + t) : 0.5;
        if (by * (r + t) > 1 + 1e-6)
            reading().warn(
                p.error(fmt::format("scatters up to {:.3g} of the light, limited to 1", by * (r + t))));
        const auto lobe = [&](const char* type, const char* name, const Texture& texture, double weight) {
            auto result = element(type);
            const float scale = weight > 0 ? by / static_cast<float>(weight) : 0;
            texture
                .changed(
                    [scale](const Rgb& c) {
                        const auto limited = [scale](float x) { return std::min(x * scale, 1.0f); };
                        return Rgb(limited(c.x), limited(c.y), limited(c.z));
                    },
                    memory())
                .addTo(result, name, false);
            return result.done();
        };
        auto result = element("blendbsdf");
        result.with("weight", share);
        result.containing(twoSided(lobe("diffuse", "reflectance", reflected, 1 - share)));
        result.containing(lobe("difftrans", "transmittance", transmitted, share));
        return result.done();
    }

    ElementPtr mix() const {
        const Parameter* names = p.find("materials");
        if (!names || names->strings.size() != 2) throw p.error("expected two names of \"materials\"");
        auto result = element("blendbsdf");
        number("amount", 0.5).addTo(result, "weight", true);
        for (const std::string& name : names->strings) result.containing(all.bsdf(all.find(name, p)));
        return result.done();
    }

    ElementPtr mirror() const {
        auto result = element("conductor");
        color("Kr", 0.9f).addTo(result, "specular_reflectance", false);
        return twoSided(result.done());
    }
    ElementPtr matte() const {
        if (!(number("sigma", 0).largest().x > 0)) return diffuse("Kd", 0.5f);
        auto result = element("roughdiffuse");
        color("Kd", 0.5f).addTo(result, "reflectance", false);
        // Degrees of Oren & Nayar's slopes; Mitsuba's alpha is their deviation times the square root of 2.
        const auto alpha = [](const Rgb& sigma) { return Rgb(std::tan(radians(sigma.x)) * std::sqrt(2.0f)); };
        number("sigma", 0).changed(alpha, memory()).addTo(result, "alpha", true);
        return twoSided(result.done());
    }
    ElementPtr oldPlastic(double roughnessFallback) const {
        p.ignore({"Ks", "Kr", "Kt", "opacity", "index"});
        return coatedDiffuse("Kd", roughnessFallback);
    }
    ElementPtr oldGlass() const {
        p.ignore({"Kr", "Kt"});
        return glass(p.has("eta") ? "eta" : "index", 0);
    }

    /// With the bumps or the normals that the material may have.
    ElementPtr bent(ElementPtr nested) const {
        const bool isOld = !p.has("displacement");
        const Texture height = number(isOld ? "bumpmap" : "displacement", 0);
        if (!height.isConstant()) {
            Maker result = element("bumpmap");
            result.containing(height.element(true));
            result.containing(std::move(nested));
            nested = result.done();
        }
        if (p.has("normalmap")) {
            const std::string file = p.requiredString("normalmap");
            const Texture map =
                all.textures_.imageFile(file, Parameters("normal map", p.where()), true, ColorSpace());
            Maker result = element("normalmap");
            map.addTo(result, "normalmap", false);
            result.containing(std::move(nested));
            nested = result.done();
        }
        return nested;
    }
};

namespace {

using MaterialMake = ElementPtr (*)(const MaterialMaker&);
struct MaterialType {
    const char* name;
    MaterialMake make;
    bool isOld;  ///< a name of version 3
};
constexpr MaterialType kMaterialTypes[] = {
    {"diffuse", [](const MaterialMaker& m) { return m.diffuse("reflectance", 0.5f); }, false},
    {"coateddiffuse", [](const MaterialMaker& m) { return m.coatedDiffuse("reflectance", 0); }, false},
    {"conductor", [](const MaterialMaker& m) { return m.twoSided(m.metal("", 0)); }, false},
    {"coatedconductor", [](const MaterialMaker& m) { return m.coatedConductor(); }, false},
    {"dielectric", [](const MaterialMaker& m) { return m.glass("eta", 0); }, false},
    {"thindielectric", [](const MaterialMaker& m) { return m.thinGlass(); }, false},
    {"diffusetransmission", [](const MaterialMaker& m) { return m.diffuseTransmission(0.25f); }, false},
    {"mix", [](const MaterialMaker& m) { return m.mix(); }, false},
    {"interface", [](const MaterialMaker& m) { return m.element("null").done(); }, false},
    {"matte", [](const MaterialMaker& m) { return m.matte(); }, true},
    {"mirror", [](const MaterialMaker& m) { return m.mirror(); }, true},
    {"metal", [](const MaterialMaker& m) { return m.twoSided(m.metal("", 0.01)); }, true},
    {"glass", [](const MaterialMaker& m) { return m.oldGlass(); }, true},
    {"plastic", [](const MaterialMaker& m) { return m.oldPlastic(0.1); }, true},
    {"substrate", [](const MaterialMaker& m) { return m.oldPlastic(0.1); }, true},
    {"uber", [](const MaterialMaker& m) { return m.oldPlastic(0.1); }, true},
};

}  // namespace

std::vector<std::string> Materials::types() {
    std::vector<std::string> names;
    for (const MaterialType& type : kMaterialTypes)
        if (!type.isOld) names.emplace_back(type.name);
    return names;
}

Materials::Handle Materials::find(const std::string& name, const Parameters& where) const {
    const auto found = named_.find(name);
    if (found != named_.end()) return found->second;
    std::vector<std::string> known;
    for (const auto& entry : named_) known.push_back(entry.first);
    const std::string nearest = nearestName(name, known);
    throw where.error(fmt::format("found no material of the name \"{}\"{}", name,
                                  nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
}

ElementPtr Materials::bsdf(const Handle& handle) {
    Definition& material = *handle;
    if (material.made) return material.made;
    const Parameters& p = material.parameters;
    constexpr size_t kDeepestMix = 64;
    if (!beingMade_.insert(&material).second) throw p.error("is a mix of itself");
    if (beingMade_.size() > kDeepestMix)
        throw p.error(fmt::format("mixes are nested more than {} levels deep", kDeepestMix));
    const MaterialMaker maker{*this, p, material.space};
    const auto* const type = std::find_if(std::begin(kMaterialTypes), std::end(kMaterialTypes),
                                          [&](const MaterialType& t) { return material.type == t.name; });
    if (type != std::end(kMaterialTypes)) {
        if (type->isOld)
            reading_.warn(
                p.error(fmt::format("\"{}\" is of pbrt 3: read as the nearest of today's", type->name)));
        material.made = maker.bent(type->make(maker));
        p.checkAllUsed(reading_);
    } else {
        const std::string nearest = nearestName(material.type, types());
        reading_.refuse(
            p.error(fmt::format("the material \"{}\" is not supported{}, expected one of {}", material.type,
                                nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                                fmt::join(types(), ", "))),
            "a gray diffuse surface stands in");
        material.made =
            maker.twoSided(maker.element("diffuse").with("reflectance", RgbValue{Rgb(0.5f)}).done());
    }
    beingMade_.erase(&material);
    return material.made;
}

}  // namespace metrolux::core::pbrt
