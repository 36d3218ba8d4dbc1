/// The principled models: the checks that every model passes, and values against formulas written out again.

#include "scattering/principled.h"

#include "bsdf_checks.h"
#include "scattering/fresnel.h"
#include "scattering/principled_thin.h"
#include "scattering/rough_dielectric.h"
#include "scattering/textures/constant.h"

#include <gtest/gtest.h>

namespace metrolux::core::test {
namespace {

TexturePtr constant(float value) { return makeConstantTexture(Rgb(value)); }
TexturePtr color(float r, float g, float b) { return makeConstantTexture(Rgb(r, g, b)); }

Vec3f direction(float cosine, float phi) {
    const float sine = std::sqrt(1 - cosine * cosine);
    return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

/// Everything but the energy bound, which Disney's lobes exceed when they are piled up.
void checkAllButEnergy(const BsdfCase& c, uint64_t seed) {
    for (const Vec3f& known : knownDirections())
        for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance}) {
            checkEvaluation(c, known, mode, seed);
            checkSampling(c, known, mode, seed);
        }
}

TEST(Principled, PassesAllChecks) {
    checkBsdf({"principled, defaults", makePrincipled({})}, 10);
    PrincipledParameters metal;
    metal.baseColor = color(0.9f, 0.6f, 0.2f);
    metal.metallic = constant(1);
    metal.roughness = constant(0.3f);
    metal.anisotropic = constant(0.8f);
    checkBsdf({"principled metal", makePrincipled(metal)}, 20);
    PrincipledParameters glass;
    glass.baseColor = constant(1);
    glass.specTrans = constant(1);
    glass.roughness = constant(0.4f);
    glass.eta = 1.5f;
    checkBsdf({"principled glass", makePrincipled(glass)}, 30);
    glass.eta = 0.8f;
    glass.anisotropic = constant(0.5f);
    checkBsdf({"principled, dense outside", makePrincipled(glass)}, 40);
    glass.specTrans = constant(0.5f);
    // Its diffuse base is not dimmed by the (here total) reflection above it.
    checkAllButEnergy({"principled, dense outside, with base", makePrincipled(glass)}, 45);
}

TEST(Principled, PassesAllChecksWithAllLobes) {
    PrincipledParameters p;
    p.baseColor = color(0.2f, 0.8f, 0.1f);
    p.roughness = constant(0.5f);
    p.anisotropic = constant(0.4f);
    p.metallic = constant(0.3f);
    p.specTrans = constant(0.4f);
    p.specTint = constant(0.6f);
    p.sheen = constant(0.9f);
    p.sheenTint = constant(0.5f);
    p.flatness = constant(0.7f);
    p.clearcoat = constant(0.8f);
    p.clearcoatGloss = constant(0.2f);
    checkAllButEnergy({"principled, all lobes", makePrincipled(p)}, 50);
    p.diffuseReflectanceSamplingRate = 0.5f;
    p.mainSpecularSamplingRate = 2;
    p.clearcoatSamplingRate = 3;
    p.specTrans = nullptr;
    checkAllButEnergy({"principled, other rates", makePrincipled(p)}, 60);
}

TEST(Principled, GlassIsTheRoughDielectric) {
    PrincipledParameters p;
    p.baseColor = constant(1);
    p.specTrans = constant(1);
    p.roughness = constant(0.6f);
    p.eta = 1.4f;
    RoughDielectricParameters q;
    q.eta = 1.4f;
    q.alphaU = q.alphaV = constant(0.36f);
    q.distribution = MicrofacetType::Ggx;
    const BsdfPtr a = makePrincipled(p), b = makeRoughDielectric(q);
    CounterRng rng(4);
    for (int i = 0; i < 2000; ++i) {
        const Vec3f eye = warp::squareToSphere(rng.next2D()), light = warp::squareToSphere(rng.next2D());
        const BsdfEvaluation x = a->evaluate(flatInteraction(), eye, light);
        const BsdfEvaluation y = b->evaluate(flatInteraction(), eye, light);
        expectClose(x.value.x, y.value.x, 1e-3, "value");
        expectClose(x.pdfLight, y.pdfLight, 1e-3, "pdfLight");
        expectClose(x.pdfEye, y.pdfEye, 1e-3, "pdfEye");
    }
}

TEST(Principled, HasTheValueOfBurleysFormulas) {
    // Plain dielectric over a diffuse base, sheen and coat; in double precision.
    const double roughness = 0.7, sheen = 0.4, coat = 0.6, gloss = 0.3, specular = 0.5, base = 0.5;
    const double eta = 2 / (1 - std::sqrt(0.08 * specular)) - 1;
    const Vec3f eye = direction(0.8f, 0.4f), light = direction(0.5f, 2.5f), m = normalize(eye + light);
    const double ci = 0.8, co = 0.5, cd = dot(eye, m), cm = m.z, pi = std::numbers::pi;
    const auto schlick = [](double c) { return std::pow(1 - c, 5); };
    const double fd90 = 2 * roughness * cd * cd;  // Burley's FD90 - 0.5
    const double lambert = (1 - 0.5 * schlick(ci)) * (1 - 0.5 * schlick(co));
    const double retro = fd90 * (schlick(ci) + schlick(co) + schlick(ci) * schlick(co) * (fd90 - 1));
    double expected = base / pi * co * (lambert + retro) + sheen * schlick(cd) * co;
    const auto g1 = [](double c, double a) { return 2 / (1 + std::sqrt(1 + a * a * (1 / (c * c) - 1))); };
    const double a2 = std::pow(roughness, 4), ac = 0.1 + (0.001 - 0.1) * gloss;
    const double d = a2 / (pi * std::pow(cm * cm * (a2 - 1) + 1, 2));
    const double alpha = roughness * roughness;
    expected += fresnelDielectric(static_cast<float>(cd), static_cast<float>(eta)) * d * g1(ci, alpha) *
                g1(co, alpha) / (4 * ci);
    const double dc = (ac * ac - 1) / (pi * std::log(ac * ac) * (1 + (ac * ac - 1) * cm * cm));
    expected += 0.25 * coat * (0.04 + 0.96 * schlick(cd)) * dc * g1(ci, 0.25) * g1(co, 0.25) * co;
    PrincipledParameters p;
    p.roughness = constant(0.7f);
    p.sheen = constant(0.4f);
    p.clearcoat = constant(0.6f);
    p.clearcoatGloss = constant(0.3f);
    const BsdfEvaluation e = makePrincipled(p)->evaluate(flatInteraction(), eye, light);
    EXPECT_NEAR(e.value.x, expected, 1e-4 * expected);
    // Lobes are chosen 1 : 1 : 0.15 (specular, diffuse, a quarter of the coat).
    const double pdf = (d * g1(ci, alpha) / (4 * ci) + co / pi + 0.25 * coat * dc * cm / (4 * cd)) / 2.15;
    EXPECT_NEAR(e.pdfLight, pdf, 1e-4 * pdf);
}

TEST(Principled, RefusesImpossibleParameters) {
    PrincipledParameters p;
    p.eta = -1.0f;
    EXPECT_THROW(makePrincipled(p), Error);
    p = {};
    p.specular = 2;
    EXPECT_THROW(makePrincipled(p), Error);
    p = {};
    p.clearcoatSamplingRate = -1;
    EXPECT_THROW(makePrincipled(p), Error);
    PrincipledThinParameters q;
    q.specularReflectanceSamplingRate = -1;
    EXPECT_THROW(makePrincipledThin(q), Error);
}

TEST(PrincipledThin, PassesAllChecks) {
    checkBsdf({"thin, defaults", makePrincipledThin({})}, 70);
    PrincipledThinParameters leaf;
    leaf.baseColor = color(0.2f, 0.7f, 0.1f);
    leaf.diffTrans = constant(1.2f);
    leaf.flatness = constant(0.5f);
    checkBsdf({"thin leaf", makePrincipledThin(leaf)}, 80);
    PrincipledThinParameters window;
    window.baseColor = constant(0.9f);
    window.specTrans = constant(1);
    window.roughness = constant(0.4f);
    BsdfCase c{"thin window", makePrincipledThin(window)};
    c.reciprocal = false;  // see the header
    checkBsdf(c, 90);
    PrincipledThinParameters all = leaf;
    all.specTrans = constant(0.6f);
    all.anisotropic = constant(0.5f);
    all.specTint = constant(0.5f);
    all.sheen = constant(0.3f);
    all.sheenTint = constant(0.8f);
    all.eta = constant(1.33f);
    all.specularReflectanceSamplingRate = 2;
    all.diffuseTransmittanceSamplingRate = 0.5f;
    c.name = "thin, all lobes";
    c.bsdf = makePrincipledThin(all);
    checkAllButEnergy(c, 100);
}

TEST(PrincipledThin, IsTheSameFromBothSides) {
    PrincipledThinParameters p;
    p.specTrans = constant(0.5f);
    p.diffTrans = constant(0.6f);
    const BsdfPtr thin = makePrincipledThin(p);
    CounterRng rng(6);
    for (int i = 0; i < 200; ++i) {
        const Vec3f eye = warp::squareToSphere(rng.next2D()), light = warp::squareToSphere(rng.next2D());
        const BsdfEvaluation a = thin->evaluate(flatInteraction(), eye, light);
        const BsdfEvaluation b = thin->evaluate(flatInteraction(), -eye, -light);
        EXPECT_EQ(a.value, b.value);
        EXPECT_EQ(a.pdfLight, b.pdfLight);
        EXPECT_EQ(a.pdfEye, b.pdfEye);
    }
}

TEST(PrincipledModels, StayFiniteAtGrazingAngles) {
    PrincipledParameters p;
    p.roughness = constant(0);
    p.specTrans = p.clearcoat = p.sheen = p.flatness = constant(0.5f);
    p.clearcoatGloss = constant(1);
    PrincipledThinParameters q;
    q.roughness = constant(0);
    q.specTrans = q.diffTrans = q.flatness = constant(0.5f);
    CounterRng rng(8);
    for (const BsdfPtr& bsdf : {makePrincipled(p), makePrincipledThin(q)})
        for (const float cosine : {1e-2f, 1e-4f, 1e-7f, 1e-20f, 1e-38f, -1e-3f, -1e-20f})
            for (int i = 0; i < 500; ++i) {
                const Vec3f known(std::sqrt(1 - cosine * cosine), 0, cosine);
                const float lobe = rng.next1D();
                const auto s =
                    bsdf->sample(flatInteraction(), known, TransportMode::Importance, lobe, rng.next2D());
                if (s) {
                    ASSERT_TRUE(isFinite(s->weight) && isFinite(s->direction)) << cosine;
                    ASSERT_TRUE(std::isfinite(s->pdfForward) && std::isfinite(s->pdfReverse)) << cosine;
                }
                for (const Vec3f& other :
                     {Vec3f(-known.x, 0, known.z), -known, warp::squareToSphere(rng.next2D())}) {
                    const BsdfEvaluation e = bsdf->evaluate(flatInteraction(), known, other);
                    ASSERT_TRUE(isFinite(e.value)) << cosine;
                    ASSERT_TRUE(std::isfinite(e.pdfLight) && std::isfinite(e.pdfEye)) << cosine;
                }
            }
}

}  // namespace
}  // namespace metrolux::core::test
