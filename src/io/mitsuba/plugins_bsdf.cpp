/// BSDFs: Mitsuba 3's parameters and defaults, and what 0.6 scenes need in addition.

#include "io/mitsuba/context.h"
#include "io/mitsuba/unknown_plugins.h"
#include "io/mitsuba/values.h"
#include "scattering/blend.h"
#include "scattering/bump_map.h"
#include "scattering/coating.h"
#include "scattering/conductor.h"
#include "scattering/dielectric.h"
#include "scattering/diffuse.h"
#include "scattering/diffuse_transmitter.h"
#include "scattering/ior_table.h"
#include "scattering/mask.h"
#include "scattering/mixture.h"
#include "scattering/normal_map.h"
#include "scattering/null_bsdf.h"
#include "scattering/phong.h"
#include "scattering/plastic.h"
#include "scattering/principled.h"
#include "scattering/principled_thin.h"
#include "scattering/rough_conductor.h"
#include "scattering/rough_dielectric.h"
#include "scattering/rough_diffuse.h"
#include "scattering/rough_plastic.h"
#include "scattering/textures/constant.h"
#include "scattering/thin_dielectric.h"
#include "scattering/two_sided.h"
#include "scattering/ward.h"

namespace metrolux::core::mitsuba {
namespace {

std::string joined(const std::vector<std::string>& names) {
    std::string result;
    for (const std::string& name : names) result += (result.empty() ? "" : ", ") + name;
    return result;
}

/// What an element of the scene is made from.
struct Source {
    const Element& element;
    LoadContext& context;

    TexturePtr color(const std::string& name, float fallback) const {
        return textureProperty(element, name, context, Rgb(fallback));
    }
    TexturePtr scalar(const std::string& name, float fallback) const {
        return scalarTextureProperty(element, name, context, fallback);
    }

    /// An index of refraction as a number or a name.
    float ior(const std::string& name, const std::string& fallback) const {
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
        throw element.error(
            *property, fmt::format("found the material \"{}\", expected a number or one of: {}", material,
                                   joined(iorNames())));
    }
    float relativeIor(const std::string& interior) const {
        return ior("int_ior", interior) / ior("ext_ior", "air");
    }

    /// The nested BSDFs, in order.
    std::vector<BsdfPtr> nested(size_t least, size_t most) const {
        const std::vector<ElementPtr> children = element.childrenOf("bsdf");
        if (children.size() < least || children.size() > most)
            throw element.error(
                fmt::format("found {} nested <bsdf> elements, expected {}", children.size(),
                            least == most ? std::to_string(least) : fmt::format("{} to {}", least, most)));
        std::vector<BsdfPtr> result;
        for (const ElementPtr& child : children) result.push_back(makeBsdf(*child, context));
        return result;
    }

    /// A texture under this name, or the only one without a name.
    TexturePtr nestedTexture(const std::string& name) const {
        if (const ElementPtr child = element.child(name)) return makeTexture(*child, context);
        if (!name.empty() && element.has(name)) return textureProperty(element, name, context, Rgb(0.0f));
        const std::vector<ElementPtr> children = element.childrenOf("texture");
        if (children.size() != 1)
            throw element.error(
                fmt::format("found {} nested <texture> elements, expected one", children.size()));
        return makeTexture(*children[0], context);
    }

    /// Runs a constructor whose errors do not know where they come from.
    template <class Make, class Parameters>
    BsdfPtr make(Make&& maker, const Parameters& parameters) const {
        try {
            return maker(parameters);
        } catch (const Error& problem) {
            throw element.error(problem.what());
        }
    }
};

/// eta and k of a metal: given, or of a named material.
template <class Parameters>
void readConductor(const Source& s, Parameters& p) {
    const Element& e = s.element;
    const bool given = e.has("eta") || e.has("k");
    if (given) {
        if (e.has("material"))
            throw e.error("found \"material\" as well as \"eta\" or \"k\", expected one of the two");
        const auto read = [&](const std::string& name, float fallback) {
            if (const ElementPtr child = e.child(name)) return makeTexture(*child, s.context);
            return makeConstantTexture(unboundedColor(e, name, s.context, Rgb(fallback)));
        };
        p.eta = read("eta", 0);
        p.k = read("k", 1);
    } else {
        const std::string name = e.string("material", e.isLegacy() ? "Cu" : "none");
        const auto material = namedConductor(name);
        if (!material)
            throw e.error(fmt::format("found the material \"{}\", expected one of: {}", name,
                                      joined(conductorNames())));
        p.eta = makeConstantTexture(material->eta);
        p.k = makeConstantTexture(material->k);
    }
    if (e.has("ext_eta")) {  // 0.6: the index around the metal
        if (!p.eta->isConstant() || !p.k->isConstant())
            throw e.error("\"ext_eta\" needs constant \"eta\" and \"k\"");
        const float exterior = s.ior("ext_eta", "air");
        p.eta = makeConstantTexture(p.eta->mean() * (1 / exterior));
        p.k = makeConstantTexture(p.k->mean() * (1 / exterior));
    }
    p.specularReflectance = s.color("specular_reflectance", 1);
}

MicrofacetType readDistribution(const Source& s) {
    s.element.ignore("sample_visible");  // always
    const std::string name = s.element.string("distribution", "beckmann");
    if (name == "beckmann") return MicrofacetType::Beckmann;
    if (name == "ggx") return MicrofacetType::Ggx;
    if (s.element.isLegacy() && (name == "phong" || name == "as")) {
        s.context.warn(s.element, fmt::format("the distribution \"{}\" of 0.6 is read as beckmann", name));
        return MicrofacetType::Beckmann;
    }
    throw s.element.error(fmt::format("found the distribution \"{}\", expected beckmann or ggx", name));
}

/// alpha, or alpha_u and alpha_v.
template <class Parameters>
void readRoughness(const Source& s, Parameters& p) {
    const Element& e = s.element;
    const bool u = e.has("alpha_u"), v = e.has("alpha_v");
    if (u != v) throw e.error("found only one of \"alpha_u\" and \"alpha_v\", expected both");
    if (u && e.has("alpha")) throw e.error("found \"alpha\" as well as \"alpha_u\" and \"alpha_v\"");
    p.alphaU = s.scalar(u ? "alpha_u" : "alpha", 0.1f);
    p.alphaV = u ? s.scalar("alpha_v", 0.1f) : p.alphaU;
}

BsdfPtr diffuse(const Source& s) { return makeDiffuse({s.color("reflectance", 0.5f)}); }

BsdfPtr dielectric(const Source& s) {
    return s.make(makeDielectric,
                  DielectricParameters{s.relativeIor("bk7"), s.color("specular_reflectance", 1),
                                       s.color("specular_transmittance", 1)});
}

BsdfPtr thinDielectric(const Source& s) {
    return s.make(makeThinDielectric,
                  ThinDielectricParameters{s.relativeIor("bk7"), s.color("specular_reflectance", 1),
                                           s.color("specular_transmittance", 1)});
}

BsdfPtr roughDielectric(const Source& s) {
    RoughDielectricParameters p;
    p.eta = s.relativeIor("bk7");
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.specularTransmittance = s.color("specular_transmittance", 1);
    p.distribution = readDistribution(s);
    readRoughness(s, p);
    return s.make(makeRoughDielectric, p);
}

BsdfPtr conductor(const Source& s) {
    ConductorParameters p;
    readConductor(s, p);
    return s.make(makeConductor, p);
}

BsdfPtr roughConductor(const Source& s) {
    RoughConductorParameters p;
    readConductor(s, p);
    p.distribution = readDistribution(s);
    readRoughness(s, p);
    return s.make(makeRoughConductor, p);
}

BsdfPtr plastic(const Source& s) {
    PlasticParameters p;
    p.eta = s.relativeIor("polypropylene");
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.nonlinear = s.element.boolean("nonlinear", false);
    return s.make(makePlastic, p);
}

BsdfPtr roughPlastic(const Source& s) {
    RoughPlasticParameters p;
    p.eta = s.relativeIor("polypropylene");
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.nonlinear = s.element.boolean("nonlinear", false);
    p.distribution = readDistribution(s);
    p.alpha = s.element.number("alpha", 0.1f);
    return s.make(makeRoughPlastic, p);
}

BsdfPtr phong(const Source& s) {
    PhongParameters p;
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 0.2f);
    p.exponent = s.scalar("exponent", 30);
    return s.make(makePhong, p);
}

BsdfPtr ward(const Source& s) {
    WardParameters p;
    const std::string variant = s.element.string("variant", "balanced");
    if (variant == "ward") {
        p.variant = WardVariant::Ward;
    } else if (variant == "ward-duer") {
        p.variant = WardVariant::WardDuer;
    } else if (variant != "balanced") {
        throw s.element.error(
            fmt::format("found the variant \"{}\", expected ward, ward-duer or balanced", variant));
    }
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 0.2f);
    readRoughness(s, p);
    return s.make(makeWard, p);
}

/// What the two principled models have in common.
template <class Parameters>
void readPrincipled(const Source& s, Parameters& p) {
    p.baseColor = s.color("base_color", 0.5f);
    p.roughness = s.scalar("roughness", 0.5f);
    p.anisotropic = s.scalar("anisotropic", 0);
    p.specTrans = s.scalar("spec_trans", 0);
    p.specTint = s.scalar("spec_tint", 0);
    p.sheen = s.scalar("sheen", 0);
    p.sheenTint = s.scalar("sheen_tint", 0);
    p.flatness = s.scalar("flatness", 0);
    p.diffuseReflectanceSamplingRate = s.element.number("diffuse_reflectance_sampling_rate", 1);
}

BsdfPtr principled(const Source& s) {
    const Element& e = s.element;
    PrincipledParameters p;
    readPrincipled(s, p);
    p.metallic = s.scalar("metallic", 0);
    p.clearcoat = s.scalar("clearcoat", 0);
    p.clearcoatGloss = s.scalar("clearcoat_gloss", 0);
    if (e.has("eta") && e.has("specular"))
        throw e.error("found both \"eta\" and \"specular\", expected one of the two");
    if (e.has("eta")) p.eta = e.number("eta", 1.5f);
    p.specular = e.number("specular", 0.5f);
    p.mainSpecularSamplingRate = e.number("main_specular_sampling_rate", 1);
    p.clearcoatSamplingRate = e.number("clearcoat_sampling_rate", 1);
    return s.make(makePrincipled, p);
}

BsdfPtr principledThin(const Source& s) {
    PrincipledThinParameters p;
    readPrincipled(s, p);
    p.eta = s.scalar("eta", 1.5f);
    p.diffTrans = s.scalar("diff_trans", 0);
    p.diffuseTransmittanceSamplingRate = s.element.number("diffuse_transmittance_sampling_rate", 1);
    p.specularReflectanceSamplingRate = s.element.number("specular_reflectance_sampling_rate", 1);
    p.specularTransmittanceSamplingRate = s.element.number("specular_transmittance_sampling_rate", 1);
    return s.make(makePrincipledThin, p);
}

BsdfPtr twoSided(const Source& s) {
    const std::vector<BsdfPtr> nested = s.nested(1, 2);
    return s.make(makeTwoSided, TwoSidedParameters{nested.front(), nested.back()});
}

BsdfPtr mask(const Source& s) { return makeMask({s.scalar("opacity", 0.5f), s.nested(1, 1)[0]}); }

BsdfPtr blend(const Source& s) {
    const std::vector<BsdfPtr> nested = s.nested(2, 2);
    return makeBlend({s.scalar("weight", 0.5f), nested[0], nested[1]});
}

/// 0.6: weights as one text, for as many nested BSDFs.
BsdfPtr mixture(const Source& s) {
    const Element& e = s.element;
    const std::vector<BsdfPtr> nested = s.nested(1, 64);
    const std::string text = e.requiredString("weights");
    std::vector<double> weights;
    try {
        weights = parseNumberList(text);
    } catch (const Error& problem) {
        throw e.error(*e.find("weights"), problem.what());
    }
    if (weights.size() != nested.size())
        throw e.error(*e.find("weights"),
                      fmt::format("found {} weights for {} nested <bsdf> elements, expected as many",
                                  weights.size(), nested.size()));
    double sum = 0;
    for (const double w : weights) sum += w;
    if (sum > 1) s.context.warn(e, fmt::format("the sum of the weights, {:.3g}, is scaled to 1", sum));
    MixtureParameters p;
    for (size_t i = 0; i < nested.size(); ++i)
        p.parts.push_back({static_cast<float>(weights[i] / std::max(sum, 1.0)), nested[i]});
    return s.make(makeMixture, p);
}

BsdfPtr coating(const Source& s) {
    CoatingParameters p;
    p.eta = s.relativeIor("bk7");
    p.thickness = s.element.number("thickness", 1);
    if (const ElementPtr child = s.element.child("sigma_a"))
        p.sigmaA = makeTexture(*child, s.context);
    else
        p.sigmaA = makeConstantTexture(unboundedColor(s.element, "sigma_a", s.context, Rgb(0.0f)));
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.base = s.nested(1, 1)[0];
    if (s.element.type == "roughcoating") {
        const float alpha = s.element.number("alpha", 0.1f);
        p.facets.emplace(readDistribution(s), alpha, alpha);
    }
    return s.make(makeCoating, p);
}

BsdfPtr roughDiffuse(const Source& s) {
    return makeRoughDiffuse(
        {s.color("reflectance", 0.5f), s.scalar("alpha", 0.2f), s.element.boolean("use_fast_approx", false)});
}

BsdfPtr diffuseTransmitter(const Source& s) {
    return makeDiffuseTransmitter({s.color("transmittance", 0.5f)});
}

PerturbationOptions perturbation(const Source& s) {
    return {s.element.boolean("flip_invalid_normals", true),
            s.element.boolean("use_shadowing_function", true)};
}

BsdfPtr bumpMap(const Source& s) {
    return makeBumpMap(
        {s.nestedTexture(""), s.element.number("scale", 1), s.nested(1, 1)[0], perturbation(s)});
}

BsdfPtr normalMap(const Source& s) {
    return makeNormalMap({s.nestedTexture("normalmap"), s.nested(1, 1)[0], perturbation(s)});
}

BsdfPtr nothing(const Source&) { return makeNullBsdf(); }

using Factory = BsdfPtr (*)(const Source&);
const std::vector<std::pair<std::string, Factory>> kFactories = {
    {"diffuse", diffuse},
    {"dielectric", dielectric},
    {"thindielectric", thinDielectric},
    {"roughdielectric", roughDielectric},
    {"conductor", conductor},
    {"roughconductor", roughConductor},
    {"plastic", plastic},
    {"roughplastic", roughPlastic},
    {"principled", principled},
    {"principledthin", principledThin},
    {"phong", phong},
    {"ward", ward},
    {"twosided", twoSided},
    {"mask", mask},
    {"blendbsdf", blend},
    {"bumpmap", bumpMap},
    {"normalmap", normalMap},
    {"null", nothing},
    {"mixturebsdf", mixture},
    {"coating", coating},
    {"roughcoating", coating},
    {"roughdiffuse", roughDiffuse},
    {"difftrans", diffuseTransmitter},
};

BsdfPtr unknown(const Element& element, LoadContext& context) {
    const std::string message = unknownPlugin(element, "BSDF", bsdfTypes());
    if (!context.lenient) throw element.error(message);
    context.warn(element, message + " (a gray diffuse surface stands in)");
    return makeDiffuse({makeConstantTexture(Rgb(0.5f))});
}

}  // namespace

std::vector<std::string> bsdfTypes() {
    std::vector<std::string> names;
    for (const auto& [name, factory] : kFactories) names.push_back(name);
    return names;
}

BsdfPtr makeBsdf(const Element& element, LoadContext& context) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return std::static_pointer_cast<const Bsdf>(found->second);
    BsdfPtr result;
    for (const auto& [name, factory] : kFactories)
        if (element.type == name) result = factory({element, context});
    if (result) {
        element.checkAllUsed(context.lenient, context.warnings);
    } else {
        result = unknown(element, context);
    }
    context.built[&element] = result;
    return result;
}

}  // namespace metrolux::core::mitsuba
