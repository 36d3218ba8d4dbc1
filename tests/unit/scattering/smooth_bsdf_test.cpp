/// The models without microfacets, and the wrappers, through the common checks.
#include "bsdf_checks.h"
#include "scattering/diffuse.h"
#include "scattering/textures/constant.h"

namespace metrolux {
namespace {

using test::BsdfCase;
using test::checkBsdf;

TexturePtr grey(float value) { return makeConstantTexture(Rgb(value)); }
TexturePtr colour(float r, float g, float b) { return makeConstantTexture(Rgb(r, g, b)); }

TEST(SmoothBsdf, Diffuse) {
    checkBsdf({"diffuse", makeDiffuse({colour(0.2f, 0.9f, 0.5f)})});
    checkBsdf({"black", makeDiffuse({grey(0)})});
}

}  // namespace
}  // namespace metrolux
