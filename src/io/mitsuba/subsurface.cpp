#include "io/mitsuba/subsurface.h"

#include "io/mitsuba/bsdf_source.h"
#include "io/mitsuba/media.h"
#include "io/mitsuba/unknown_plugins.h"
#include "scattering/dielectric.h"
#include "scattering/rough_dielectric.h"

#include <algorithm>

namespace metrolux::core::mitsuba {
namespace {

/// Properties of the boundary and of the approximation; the others are those of the medium.
constexpr const char* kBoundary[] = {"int_ior", "ext_ior"};
constexpr const char* kSampling[] = {"irr_samples", "irr_indirect", "quality", "sample_multiplier"};

/// The index of refraction that 0.6 has for its materials.
float indexOf(const std::string& material) {
    std::string name = material;
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (name == "marble") return 1.5f;
    const char* const measured2001[] = {"apple",   "chicken1",   "chicken2", "cream",
                                        "ketchup", "potato",     "skimmilk", "skin1",
                                        "skin2",   "spectralon", "wholemilk"};
    return std::find(std::begin(measured2001), std::end(measured2001), name) != std::end(measured2001)
               ? 1.3f
               : 1.33f;
}

/// The medium of a `dipole`, which shapes may share.
MediumIndex mediumOfDipole(const ElementPtr& dipole, LoadContext& context) {
    if (const auto found = context.mediumIndices.find(dipole.get()); found != context.mediumIndices.end())
        return found->second;
    Element medium = *dipole;
    medium.tag = "medium";
    medium.type = "homogeneous";
    const auto isOther = [](const auto& entry) {
        const auto has = [&](const char* name) { return entry.first == name; };
        return std::any_of(std::begin(kBoundary), std::end(kBoundary), has) ||
               std::any_of(std::begin(kSampling), std::end(kSampling), has);
    };
    std::erase_if(medium.named, isOther);
    return context.mediumIndices[dipole.get()] = addMedium(medium, context);
}

/// The model of facets that the shape's own BSDF has, or null.
const Element* roughModel(const ElementPtr& bsdf) {
    if (!bsdf) return nullptr;
    if (bsdf->type == "twosided") {
        const auto nested = bsdf->childrenOf("bsdf");
        return nested.empty() ? nullptr : roughModel(nested.front());
    }
    const bool isRough = bsdf->type == "roughplastic" || bsdf->type == "roughdielectric";
    return isRough ? bsdf.get() : nullptr;
}

BsdfPtr boundaryOf(const Element& dipole, const ElementPtr& bsdf, LoadContext& context) {
    const BsdfSource source{dipole, context};
    const float inside =
        dipole.has("int_ior") ? source.ior("int_ior", "") : indexOf(dipole.string("material", "skin1"));
    const float eta = inside / source.ior("ext_ior", "air");
    const Element* const rough = roughModel(bsdf);
    if (!rough || eta == 1) return source.make(makeDielectric, DielectricParameters{eta, nullptr, nullptr});
    const BsdfSource own{*rough, context};
    RoughDielectricParameters p;
    p.eta = eta;
    p.distribution = own.distribution();
    readRoughness(own, p);
    return source.make(makeRoughDielectric, p);
}

}  // namespace

std::optional<SubsurfaceParts> subsurfaceOf(const Element& shape, const ElementPtr& bsdf,
                                            LoadContext& context) {
    const std::vector<ElementPtr> found = shape.childrenOf("subsurface");
    if (found.empty()) return std::nullopt;
    const ElementPtr& dipole = found.front();
    if (found.size() > 1)
        throw found[1]->error("found a second <subsurface> in a shape, expected one at most");
    if (dipole->type != "dipole") {
        const std::string message = unknownPlugin(*dipole, "subsurface scattering", {"dipole"});
        if (!context.lenient) throw dipole->error(message);
        context.warn(*dipole, message + " (it is left out)");
        return std::nullopt;
    }
    if (!shape.childrenOf("medium").empty())
        throw dipole->error("found a medium beside it, expected one of the two");
    context.warn(*dipole,
                 "read as the medium that it approximates, in a dielectric boundary; of the shape's BSDF the "
                 "roughness holds");
    SubsurfaceParts result;
    result.media.interior = mediumOfDipole(dipole, context);
    result.boundary = boundaryOf(*dipole, bsdf, context);
    for (const auto& entry : dipole->named) dipole->ignore(entry.first);
    return result;
}

}  // namespace metrolux::core::mitsuba
