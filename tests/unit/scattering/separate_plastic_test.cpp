/// Plastic without exchange between its parts, and roughness that varies.

#include "scattering/separate_plastic.h"

#include "bsdf_checks.h"
#include "scattering/coating.h"
#include "scattering/diffuse.h"
#include "scattering/fresnel.h"
#include "scattering/rough_plastic.h"
#include "scattering/textures/checkerboard.h"
#include "scattering/textures/constant.h"

#include <gtest/gtest.h>

namespace metrolux::core::test {
namespace {

TexturePtr constant(float value) { return makeConstantTexture(Rgb(value)); }

TEST(SeparatePlastic, PassesAllChecks) {
    for (const MicrofacetType type : {MicrofacetType::Ggx, MicrofacetType::Beckmann}) {
        SeparatePlasticParameters p;
        p.distribution = type;
        p.alphaU = constant(0.05f);
        p.alphaV = constant(0.3f);
        checkBsdf({"separate plastic", makeSeparatePlastic(p)}, 300 + static_cast<int>(type));
    }
    SeparatePlasticParameters black;
    black.diffuseReflectance = constant(0);
    checkBsdf({"separate plastic without a base", makeSeparatePlastic(black)}, 310);
}

TEST(SeparatePlastic, HasTheValueOfTheFormula) {
    SeparatePlasticParameters p;
    p.specularReflectance = constant(0);
    p.eta = 1.5f;
    const Vec3f eye(0.6f, 0, 0.8f), light(0, 0.8f, 0.6f);
    const BsdfEvaluation e = makeSeparatePlastic(p)->evaluate(flatInteraction(), eye, light);
    const float passed = (1 - fresnelDielectric(0.8f, 1.5f)) * (1 - fresnelDielectric(0.6f, 1.5f));
    EXPECT_NEAR(e.value.x, 0.5f * passed * 0.6f * kInvPi, 1e-6f);
    p.eta = 1;
    EXPECT_THROW(makeSeparatePlastic(p), Error);
}

/// Its uv in flatInteraction() have one value, others the other.
TexturePtr squares(float here, float there) {
    return makeCheckerboard({constant(there), constant(here), {}});
}

TEST(TexturedRoughness, OfPlasticIsThatOfTheNumber) {
    for (const float alpha : {0.03f, 0.2f, 0.6f}) {
        RoughPlasticParameters number, texture;
        number.alpha = alpha;
        texture.alphaTexture = squares(alpha, 0.9f);
        SurfaceInteraction si = flatInteraction();
        if (std::abs(texture.alphaTexture->scalar(si) - alpha) > 1e-6f) si.uv = {0.3f, 0.3f};
        ASSERT_NEAR(texture.alphaTexture->scalar(si), alpha, 1e-6f);
        const BsdfPtr a = makeRoughPlastic(number), b = makeRoughPlastic(texture);
        for (const Vec3f& eye : {Vec3f(0.6f, 0, 0.8f), Vec3f(0.28f, 0, 0.96f)}) {
            const Vec3f light(-0.48f, 0.36f, 0.8f);
            const BsdfEvaluation x = a->evaluate(si, eye, light), y = b->evaluate(si, eye, light);
            EXPECT_NEAR(y.value.x, x.value.x, 0.005f * x.value.x) << alpha;
            EXPECT_NEAR(y.pdfLight, x.pdfLight, 0.005f * x.pdfLight) << alpha;
        }
        checkBsdf({"plastic of varying roughness", b, true, true, si}, 320 + static_cast<int>(10 * alpha));
    }
}

TEST(TexturedRoughness, OfCoatings) {
    CoatingParameters p;
    p.base = makeDiffuse({constant(0.8f)});
    p.alpha = squares(0.3f, 0.05f);
    checkBsdf({"coating of varying roughness", makeCoating(p)}, 330);
}

}  // namespace
}  // namespace metrolux::core::test
