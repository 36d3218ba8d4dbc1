/// Coatings, mixtures, rough diffuse surfaces and diffuse transmitters: the checks that every model passes,
/// and values against formulas written out again.

#include "bsdf_checks.h"
#include "scattering/coating.h"
#include "scattering/conductor.h"
#include "scattering/dielectric.h"
#include "scattering/diffuse.h"
#include "scattering/diffuse_transmitter.h"
#include "scattering/fresnel.h"
#include "scattering/mixture.h"
#include "scattering/phong.h"
#include "scattering/rough_conductor.h"
#include "scattering/rough_diffuse.h"
#include "scattering/textures/constant.h"
#include "scattering/two_sided.h"

#include <gtest/gtest.h>

namespace metrolux::core::test {
namespace {

TexturePtr constant(float value) { return makeConstantTexture(Rgb(value)); }
BsdfPtr gray(float reflectance) { return makeDiffuse({constant(reflectance)}); }

Vec3f direction(float cosine, float phi) {
    const float sine = std::sqrt(1 - cosine * cosine);
    return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

BsdfPtr metal(float alpha) {
    RoughConductorParameters p;
    p.eta = constant(0.2f);
    p.k = constant(3);
    p.alphaU = p.alphaV = constant(alpha);
    return makeRoughConductor(p);
}

TEST(RoughDiffuse, PassesAllChecks) {
    for (const bool fast : {false, true})
        for (const float alpha : {0.0f, 0.2f, 0.7f})
            checkBsdf({fmt::format("rough diffuse {} {}", alpha, fast),
                       makeRoughDiffuse({constant(0.9f), constant(alpha), fast})},
                      100 + static_cast<int>(10 * alpha) + fast);
}

TEST(RoughDiffuse, IsLambertianWhereItIsSmooth) {
    const BsdfEvaluation e = makeRoughDiffuse({constant(0.6f), constant(0), false})
                                 ->evaluate(flatInteraction(), direction(0.4f, 1), direction(0.7f, 3));
    EXPECT_NEAR(e.value.x, 0.6f * 0.7f * kInvPi, 1e-6f);
}

TEST(RoughDiffuse, HasTheValueOfTheFormula) {
    // The qualitative model for sigma = 0.5 (alpha = 0.5 sqrt 2), angles of 60 and 30 degrees in one plane.
    const float alpha = 0.5f * std::sqrt(2.0f);
    const double sigma2 = 0.25, a = 1 - 0.5 * sigma2 / (sigma2 + 0.33), b = 0.45 * sigma2 / (sigma2 + 0.09);
    const double expected = (a + b * std::sin(std::numbers::pi / 3) * std::tan(std::numbers::pi / 6)) *
                            std::cos(std::numbers::pi / 6) / std::numbers::pi;
    const Vec3f eye = direction(0.5f, 1), light = direction(std::sqrt(0.75f), 1);
    const BsdfPtr bsdf = makeRoughDiffuse({constant(1), constant(alpha), true});
    EXPECT_NEAR(bsdf->evaluate(flatInteraction(), eye, light).value.x, expected, 1e-5);
    // The full one against 0.6's definition: single and double scattering.
    const double t1 = std::numbers::pi / 3, t2 = std::numbers::pi / 6;
    const double single = a + b * std::sin(t1) * std::tan(t2);
    const double twice = 0.17 * sigma2 / (sigma2 + 0.13) * (1 - std::pow(2 * t2 / std::numbers::pi, 2));
    const BsdfPtr full = makeRoughDiffuse({constant(0.5f), constant(alpha), false});
    EXPECT_NEAR(full->evaluate(flatInteraction(), eye, light).value.x,
                (0.5 * single + 0.25 * twice) * std::cos(t2) / std::numbers::pi, 1e-5);
}

TEST(DiffuseTransmitter, PassesAllChecks) {
    checkBsdf({"diffuse transmitter", makeDiffuseTransmitter({constant(0.8f)})}, 200);
    const BsdfEvaluation e = makeDiffuseTransmitter({constant(0.8f)})
                                 ->evaluate(flatInteraction(), direction(0.4f, 1), -direction(0.7f, 3));
    EXPECT_NEAR(e.value.x, 0.8f * 0.7f * kInvPi, 1e-6f);
}

TEST(Mixture, PassesAllChecks) {
    checkBsdf({"three models", makeMixture({{{0.2f, gray(0.8f)}, {0.5f, metal(0.3f)}, {0.2f, gray(0.1f)}}})},
              210);
    checkBsdf({"a delta lobe", makeMixture({{{0.3f, makeConductor({})}, {0.6f, gray(0.5f)}}})}, 220);
    checkBsdf({"glass and a transmitter",
               makeMixture({{{0.5f, makeDielectric({})}, {0.5f, makeDiffuseTransmitter({constant(1)})}}})},
              230);
}

TEST(Mixture, ScalesAndRefuses) {
    EXPECT_NEAR(makeMixture({{{0.25f, gray(1)}, {0.5f, gray(0.5f)}}})->albedo(flatInteraction()).x, 0.5f,
                1e-6f);
    EXPECT_THROW(makeMixture({{{0.7f, gray(1)}, {0.7f, gray(1)}}}), Error);
    EXPECT_THROW(makeMixture({{{-0.1f, gray(1)}, {0.7f, gray(1)}}}), Error);
    EXPECT_THROW(makeMixture({}), Error);
}

CoatingParameters coat(BsdfPtr base, float absorption = 0) {
    CoatingParameters p;
    p.eta = 1.5f;
    p.sigmaA = constant(absorption);
    p.base = std::move(base);
    return p;
}

TEST(Coating, PassesAllChecks) {
    checkBsdf({"coated diffuse", makeCoating(coat(gray(0.9f), 0.3f))}, 300);
    checkBsdf({"coated metal", makeCoating(coat(metal(0.2f)))}, 310);
    checkBsdf({"coated on both sides", makeCoating(coat(makeTwoSided({gray(0.5f), gray(0.2f)})))}, 330);
    CoatingParameters thin = coat(gray(0.7f));
    thin.eta = 0.8f;
    checkBsdf({"a coat that is thinner than the outside", makeCoating(thin)}, 340);
}

TEST(RoughCoating, PassesAllChecks) {
    for (const MicrofacetType type : {MicrofacetType::Beckmann, MicrofacetType::Ggx})
        for (const float alpha : {0.05f, 0.3f}) {
            CoatingParameters p = coat(gray(0.8f), 0.2f);
            p.facets.emplace(type, alpha, alpha);
            checkBsdf({fmt::format("rough coating {}", alpha), makeCoating(p)},
                      350 + static_cast<int>(100 * alpha));
            p.base = metal(0.2f);
            checkBsdf({fmt::format("rough coating of metal {}", alpha), makeCoating(p)},
                      450 + static_cast<int>(100 * alpha));
        }
}

TEST(Coating, HasTheValueOfTheFormula) {
    const float eta = 1.5f, cosEye = 0.8f, cosLight = 0.4f, sigma = 0.3f;
    const BsdfEvaluation e = makeCoating(coat(gray(0.6f), sigma))
                                 ->evaluate(flatInteraction(), direction(cosEye, 1), direction(cosLight, 2));
    const auto inside = [&](double c) { return std::sqrt(1 - (1 - c * c) / (eta * eta)); };
    const double way = 1 / inside(cosEye) + 1 / inside(cosLight);
    const double expected = 0.6 / std::numbers::pi * (1 - fresnelDielectric(cosEye, eta)) *
                            (1 - fresnelDielectric(cosLight, eta)) * std::exp(-sigma * way) * cosLight /
                            (eta * eta);
    EXPECT_NEAR(e.value.x, expected, 1e-5);
}

TEST(Coating, OfAMirrorReflectsTwice) {
    // Both lobes have one direction: the outside reflects F, the mirror below (1 - F)^2 times what the layer
    // leaves.
    const float cosine = 0.8f, f = fresnelDielectric(cosine, 1.5f);
    const float inside = std::sqrt(1 - (1 - cosine * cosine) / 2.25f);
    const float expected = f + (1 - f) * (1 - f) * std::exp(-2 * 0.1f / inside);
    const BsdfPtr bsdf = makeCoating(coat(makeConductor({}), 0.1f));
    const Vec3f known = direction(cosine, 1);
    for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance}) {
        CounterRng rng(5);
        double sum = 0;
        constexpr int kSamples = 20000;
        for (int i = 0; i < kSamples; ++i) {
            const float lobe = rng.next1D();
            const auto s = bsdf->sample(flatInteraction(), known, mode, lobe, rng.next2D());
            ASSERT_TRUE(s && s->delta);
            EXPECT_NEAR((s->direction - Vec3f(-known.x, -known.y, known.z)).length(), 0, 1e-5f);
            sum += s->weight.x;
        }
        EXPECT_NEAR(sum / kSamples, expected, 0.01);
    }
}

TEST(Coating, WithoutAnInterfaceIsItsBase) {
    CoatingParameters p = coat(gray(0.6f));
    p.eta = 1;
    const Vec3f eye = direction(0.8f, 1), light = direction(0.4f, 2);
    EXPECT_NEAR(makeCoating(p)->evaluate(flatInteraction(), eye, light).value.x,
                gray(0.6f)->evaluate(flatInteraction(), eye, light).value.x, 1e-6f);
}

TEST(Coating, RefusesWhatItCannotCover) {
    EXPECT_THROW(makeCoating(coat(makeDielectric({}))), Error);
    EXPECT_THROW(makeCoating(coat(nullptr)), Error);
    CoatingParameters p = coat(gray(0.5f));
    p.eta = -1;
    EXPECT_THROW(makeCoating(p), Error);
}

}  // namespace
}  // namespace metrolux::core::test
