/// BSDFs: Mitsuba 3's parameters and defaults, and what 0.6 scenes need in addition.

#include "io/mitsuba/bsdf_source.h"
#include "io/mitsuba/unknown_plugins.h"
#include "io/mitsuba/values.h"
#include "scattering/blend.h"
#include "scattering/bump_map.h"
#include "scattering/coating.h"
#include "scattering/conductor.h"
#include "scattering/dielectric.h"
#include "scattering/diffuse.h"
#include "scattering/diffuse_transmitter.h"
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

/// eta and k of a metal: given, or of a named material.
template <class Parameters>
void readConductor(const BsdfSource& s, Parameters& p) {
    const Element& e = s.element;
    const bool given = e.has("eta") || e.has("k");
    ConductorIor metal{Rgb(0.0f), Rgb(1.0f)};
    if (!given || e.isLegacy()) {  // in 0.6 the material holds where one of them is not given
        const std::string name = e.string("material", e.isLegacy() ? "Cu" : "none");
        const auto material = namedConductor(name);
        if (!material)
            throw e.error(fmt::format("found the material \"{}\", expected one of: {}", name,
                                      fmt::join(conductorNames(), ", ")));
        metal = *material;
    } else if (e.has("material")) {
        throw e.error("found \"material\" as well as \"eta\" or \"k\", expected one of the two");
    }
    const auto read = [&](const std::string& name, const Rgb& fallback) {
        if (const ElementPtr child = e.child(name)) return makeTexture(*child, s.context);
        return makeConstantTexture(unboundedColor(e, name, s.context, fallback));
    };
    p.eta = read("eta", metal.eta);
    p.k = read("k", metal.k);
    if (e.has("ext_eta")) {  // 0.6: the index around the metal
        if (!p.eta->isConstant() || !p.k->isConstant())
            throw e.error("\"ext_eta\" needs constant \"eta\" and \"k\"");
        const float exterior = s.ior("ext_eta", "air");
        p.eta = makeConstantTexture(p.eta->mean() * (1 / exterior));
        p.k = makeConstantTexture(p.k->mean() * (1 / exterior));
    }
    p.specularReflectance = s.color("specular_reflectance", 1);
}

BsdfPtr diffuse(const BsdfSource& s) { return makeDiffuse({s.color("reflectance", 0.5f)}); }

BsdfPtr dielectric(const BsdfSource& s) {
    return s.make(makeDielectric,
                  DielectricParameters{s.indexWithDispersion("bk7"), s.color("specular_reflectance", 1),
                                       s.color("specular_transmittance", 1)});
}

BsdfPtr thinDielectric(const BsdfSource& s) {
    return s.make(makeThinDielectric,
                  ThinDielectricParameters{s.indexWithDispersion("bk7"), s.color("specular_reflectance", 1),
                                           s.color("specular_transmittance", 1)});
}

BsdfPtr roughDielectric(const BsdfSource& s) {
    RoughDielectricParameters p;
    p.eta = s.indexWithDispersion("bk7");
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.specularTransmittance = s.color("specular_transmittance", 1);
    p.distribution = s.distribution();
    readRoughness(s, p);
    return s.make(makeRoughDielectric, p);
}

BsdfPtr conductor(const BsdfSource& s) {
    ConductorParameters p;
    readConductor(s, p);
    return s.make(makeConductor, p);
}

BsdfPtr roughConductor(const BsdfSource& s) {
    RoughConductorParameters p;
    readConductor(s, p);
    p.distribution = s.distribution();
    readRoughness(s, p);
    return s.make(makeRoughConductor, p);
}

BsdfPtr plastic(const BsdfSource& s) {
    PlasticParameters p;
    p.eta = s.relativeIor("polypropylene");
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.nonlinear = s.element.boolean("nonlinear", false);
    return s.make(makePlastic, p);
}

BsdfPtr roughPlastic(const BsdfSource& s) {
    RoughPlasticParameters p;
    p.eta = s.relativeIor("polypropylene");
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.nonlinear = s.element.boolean("nonlinear", false);
    p.distribution = s.distribution();
    if (s.hasTexturedAlpha())
        p.alphaTexture = s.scalar("alpha", 0.1f);
    else
        p.alpha = s.element.number("alpha", 0.1f);
    return s.make(makeRoughPlastic, p);
}

BsdfPtr phong(const BsdfSource& s) {
    PhongParameters p;
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 0.2f);
    p.exponent = s.scalar("exponent", 30);
    return s.make(makePhong, p);
}

BsdfPtr ward(const BsdfSource& s) {
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
void readPrincipled(const BsdfSource& s, Parameters& p) {
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

BsdfPtr principled(const BsdfSource& s) {
    const Element& e = s.element;
    PrincipledParameters p;
    readPrincipled(s, p);
    p.metallic = s.scalar("metallic", 0);
    p.clearcoat = s.scalar("clearcoat", 0);
    p.clearcoatGloss = s.scalar("clearcoat_gloss", 0);
    if ((e.has("eta") || e.has("abbe")) && e.has("specular"))
        throw e.error(fmt::format("found both \"{}\" and \"specular\", expected one of the two",
                                  e.has("eta") ? "eta" : "abbe"));
    if (e.has("abbe"))
        p.eta = s.indexByAbbeNumber(e.number("eta", 1.5f), 1);
    else if (e.has("eta"))
        p.eta = e.number("eta", 1.5f);
    p.specular = e.number("specular", 0.5f);
    p.mainSpecularSamplingRate = e.number("main_specular_sampling_rate", 1);
    p.clearcoatSamplingRate = e.number("clearcoat_sampling_rate", 1);
    return s.make(makePrincipled, p);
}

BsdfPtr principledThin(const BsdfSource& s) {
    PrincipledThinParameters p;
    readPrincipled(s, p);
    p.eta = s.scalar("eta", 1.5f);
    p.diffTrans = s.scalar("diff_trans", 0);
    p.diffuseTransmittanceSamplingRate = s.element.number("diffuse_transmittance_sampling_rate", 1);
    p.specularReflectanceSamplingRate = s.element.number("specular_reflectance_sampling_rate", 1);
    p.specularTransmittanceSamplingRate = s.element.number("specular_transmittance_sampling_rate", 1);
    return s.make(makePrincipledThin, p);
}

BsdfPtr twoSided(const BsdfSource& s) {
    const std::vector<BsdfPtr> nested = s.nested(1, 2);
    return s.make(makeTwoSided, TwoSidedParameters{nested.front(), nested.back()});
}

BsdfPtr mask(const BsdfSource& s) { return makeMask({s.scalar("opacity", 0.5f), s.nested(1, 1)[0]}); }

BsdfPtr blend(const BsdfSource& s) {
    const std::vector<BsdfPtr> nested = s.nested(2, 2);
    return makeBlend({s.scalar("weight", 0.5f), nested[0], nested[1]});
}

/// 0.6: weights as one text, for as many nested BSDFs.
BsdfPtr mixture(const BsdfSource& s) {
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

BsdfPtr coating(const BsdfSource& s) {
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
        p.distribution = s.distribution();
        if (s.hasTexturedAlpha()) {
            p.alpha = s.scalar("alpha", 0.1f);
        } else {
            const float alpha = s.element.number("alpha", 0.1f);
            p.facets.emplace(p.distribution, alpha, alpha);
        }
    }
    return s.make(makeCoating, p);
}

BsdfPtr roughDiffuse(const BsdfSource& s) {
    return makeRoughDiffuse(
        {s.color("reflectance", 0.5f), s.scalar("alpha", 0.2f), s.element.boolean("use_fast_approx", false)});
}

BsdfPtr diffuseTransmitter(const BsdfSource& s) {
    return makeDiffuseTransmitter({s.color("transmittance", 0.5f)});
}

PerturbationOptions perturbation(const BsdfSource& s) {
    return {s.element.boolean("flip_invalid_normals", true),
            s.element.boolean("use_shadowing_function", true)};
}

BsdfPtr bumpMap(const BsdfSource& s) {
    return makeBumpMap(
        {s.nestedTexture(""), s.element.number("scale", 1), s.nested(1, 1)[0], perturbation(s)});
}

BsdfPtr normalMap(const BsdfSource& s) {
    return makeNormalMap({s.nestedTexture("normalmap"), s.nested(1, 1)[0], perturbation(s)});
}

BsdfPtr nothing(const BsdfSource&) { return makeNullBsdf(); }

using BsdfFactory = BsdfPtr (*)(const BsdfSource&);
const std::vector<std::pair<std::string, BsdfFactory>> kBsdfFactories = {
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
    {"polarizer", makePolarizer},
    {"circular", makePolarizer},
    {"retarder", makeRetarder},
    {"pplastic", makePlasticWithoutPolarization},
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
    for (const auto& [name, factory] : kBsdfFactories) names.push_back(name);
    return names;
}

BsdfPtr makeBsdf(const Element& element, LoadContext& context) {
    if (const auto found = context.built.find(&element); found != context.built.end())
        return std::static_pointer_cast<const Bsdf>(found->second);
    BsdfPtr result;
    for (const auto& [name, factory] : kBsdfFactories)
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
