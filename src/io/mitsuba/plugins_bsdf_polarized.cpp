/// BSDFs of Mitsuba 3 that polarize, as they are where it renders without polarization.

#include "io/mitsuba/bsdf_source.h"
#include "scattering/separate_plastic.h"
#include "scattering/textures/scaled.h"
#include "scattering/thin_dielectric.h"

namespace metrolux::core::mitsuba {
namespace {

constexpr const char* kUnpolarized =
    "images are not polarized: read as in Mitsuba's modes without polarization";

/// A sheet without a reflection that lets this part of the light pass.
BsdfPtr sheet(const BsdfSource& s, float part) {
    s.context.warn(s.element, kUnpolarized);
    for (const char* angle : {"theta", "delta"}) s.scalar(angle, 0);
    ThinDielectricParameters p;
    p.eta = 1;
    p.specularTransmittance = makeScaledTexture({s.color("transmittance", 1), Rgb(part)});
    return s.make(makeThinDielectric, p);
}

}  // namespace

BsdfPtr makePolarizer(const BsdfSource& s) {
    s.element.boolean("left_handed", false);
    s.element.boolean("polarize_light", true);
    return sheet(s, 0.5f);
}

BsdfPtr makeRetarder(const BsdfSource& s) { return sheet(s, 1); }

BsdfPtr makePlasticWithoutPolarization(const BsdfSource& s) {
    s.context.warn(s.element, kUnpolarized);
    SeparatePlasticParameters p;
    p.eta = s.relativeIor("polypropylene");
    p.diffuseReflectance = s.color("diffuse_reflectance", 0.5f);
    p.specularReflectance = s.color("specular_reflectance", 1);
    p.distribution = s.distribution();
    readRoughness(s, p);
    return s.make(makeSeparatePlastic, p);
}

}  // namespace metrolux::core::mitsuba
