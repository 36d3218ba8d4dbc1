#pragma once
/// What the factories of BSDFs read in the same way.

#include "io/mitsuba/context.h"
#include "scattering/ior_table.h"
#include "scattering/microfacet.h"
#include "scattering/refractive_index.h"

namespace metrolux::core::mitsuba {

/// The element that a BSDF is made from.
struct BsdfSource {
    const Element& element;
    LoadContext& context;

    TexturePtr color(const std::string& name, float fallback) const {
        return textureProperty(element, name, context, Rgb(fallback));
    }
    TexturePtr scalar(const std::string& name, float fallback) const {
        return scalarTextureProperty(element, name, context, fallback);
    }

    /// The roughness of layers varies in 0.6 only.
    bool hasTexturedAlpha() const {
        const Property* alpha = element.find("alpha");
        return alpha && element.isLegacy() && std::holds_alternative<ElementPtr>(alpha->value);
    }

    /// An index of refraction as a number or a name.
    float ior(const std::string& name, const std::string& fallback) const;
    float relativeIor(const std::string& interior) const {
        return ior("int_ior", interior) / ior("ext_ior", "air");
    }
    /// The same as relativeIor(), or with dispersion if the element has one of
    ///   abbe        number, with int_ior as the index at the d line
    ///   cauchy      "A, B" or "A, B, C"
    ///   sellmeier   "B1, B2, B3, C1, C2, C3", or fewer or more of both
    ///   glass       name of a material (Dispersion::named)
    /// Lengths are in micrometers. Throws Error for more than one of them, and for what Dispersion refuses.
    RelativeIndex indexWithDispersion(const std::string& interior) const;
    /// With the element's Abbe number. Throws Error for what Dispersion refuses.
    RelativeIndex indexByAbbeNumber(float interior, float exterior) const;
    MicrofacetType distribution() const;

    /// The nested BSDFs, in order.
    std::vector<BsdfPtr> nested(size_t least, size_t most) const;
    /// A texture under this name, or the only one without a name.
    TexturePtr nestedTexture(const std::string& name) const;

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

/// alpha, or alpha_u and alpha_v.
template <class Parameters>
void readRoughness(const BsdfSource& s, Parameters& p) {
    const Element& e = s.element;
    const bool u = e.has("alpha_u"), v = e.has("alpha_v");
    if (u != v) throw e.error("found only one of \"alpha_u\" and \"alpha_v\", expected both");
    if (u && e.has("alpha")) throw e.error("found \"alpha\" as well as \"alpha_u\" and \"alpha_v\"");
    p.alphaU = s.scalar(u ? "alpha_u" : "alpha", 0.1f);
    p.alphaV = u ? s.scalar("alpha_v", 0.1f) : p.alphaU;
}

// What reads polarization, and does without it (plugins_bsdf_polarized.cpp).
BsdfPtr makePolarizer(const BsdfSource& source);
BsdfPtr makeRetarder(const BsdfSource& source);
BsdfPtr makePlasticWithoutPolarization(const BsdfSource& source);

}  // namespace metrolux::core::mitsuba
