/// Rough conductor and rough dielectric: the checks that every model passes, energy, and values against
/// formulas that are written out here again.

#include "bsdf_checks.h"
#include "scattering/fresnel.h"
#include "scattering/rough_conductor.h"
#include "scattering/rough_dielectric.h"
#include "scattering/textures/constant.h"

#include <gtest/gtest.h>

namespace metrolux::core::test {
namespace {

TexturePtr constant(float value) { return makeConstantTexture(Rgb(value)); }

BsdfPtr conductor(MicrofacetType type, float alphaU, float alphaV, const Rgb& eta = Rgb(0.2f, 0.9f, 1.1f),
                  const Rgb& k = Rgb(3.9f, 2.4f, 2.2f)) {
    RoughConductorParameters p;
    p.distribution = type;
    p.alphaU = constant(alphaU);
    p.alphaV = constant(alphaV);
    p.eta = makeConstantTexture(eta);
    p.k = makeConstantTexture(k);
    return makeRoughConductor(p);
}

BsdfPtr dielectric(MicrofacetType type, float alphaU, float alphaV, float eta = 1.5f) {
    RoughDielectricParameters p;
    p.distribution = type;
    p.alphaU = constant(alphaU);
    p.alphaV = constant(alphaV);
    p.eta = eta;
    return makeRoughDielectric(p);
}

Vec3f direction(float cosine, float phi) {
    const float sine = std::sqrt(1 - cosine * cosine);
    return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

/// Energy that leaves for one that arrives, mean over a grid of samples.
float albedoOf(const Bsdf& bsdf, const Vec3f& known, TransportMode mode, int n = 200) {
    const SurfaceInteraction si = flatInteraction();
    double sum = 0;
    CounterRng rng(77);
    for (int i = 0; i < n * n; ++i) {
        const Vec2f u((static_cast<float>(i % n) + 0.5f) / static_cast<float>(n),
                      (static_cast<float>(i / n) + 0.5f) / static_cast<float>(n));
        const auto s = bsdf.sample(si, known, mode, rng.next1D(), u);
        if (!s) continue;
        sum +=
            s->weight.x * (mode == TransportMode::Radiance ? s->eta * s->eta
                                                           : absCosTheta(s->direction) / absCosTheta(known));
    }
    return static_cast<float>(sum / (n * n));
}

struct Roughness {
    MicrofacetType type;
    float alphaU, alphaV;
};

class RoughBsdf : public ::testing::TestWithParam<Roughness> {};

TEST_P(RoughBsdf, ConductorPassesAllChecks) {
    const auto [type, u, v] = GetParam();
    checkBsdf({"rough conductor", conductor(type, u, v)}, 100);
}

TEST_P(RoughBsdf, DielectricPassesAllChecks) {
    const auto [type, u, v] = GetParam();
    if (u < 0.1f) return;  // too narrow for the quadrature of the chi-square test; see the next one
    checkBsdf({"rough dielectric", dielectric(type, u, v)}, 200);
    checkBsdf({"rough dielectric, dense outside", dielectric(type, u, v, 0.7f)}, 300);
}

TEST_P(RoughBsdf, DensityMatchesSamplesInTheMiddleOfEachLobe) {
    // For any region of directions, the mean of 1 / pdf over the samples inside it is its solid angle. The
    // region is a cap of one lobe width around the mirrored or refracted direction: no limit on how narrow
    // the lobe is.
    const auto [type, u, v] = GetParam();
    const float width = std::min(u, v), eta = 1.5f;
    const SurfaceInteraction si = flatInteraction();
    const BsdfPtr glass = dielectric(type, u, v, eta);
    CounterRng rng(11);
    for (const float cosine : {0.95f, 0.5f, -0.9f})
        for (const bool transmitted : {false, true})
            for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance}) {
                const Vec3f known = direction(cosine, 0.8f);
                float cosT, etaIt, etaTi;
                fresnelDielectric(known.z, eta, cosT, etaIt, etaTi);
                const Vec3f axis =
                    transmitted ? Vec3f(-known.x * etaTi, -known.y * etaTi, cosT) : reflectLocal(known);
                if (std::abs(axis.z) < 1e-3f) continue;  // total reflection
                const double cap = 1 - std::cos((transmitted ? 0.4 : 1.0) * std::min(0.3f, width));
                constexpr int kSamples = 40000;
                double sum = 0, squares = 0;
                for (int i = 0; i < kSamples; ++i) {
                    const float lobe = rng.next1D();
                    const auto s = glass->sample(si, known, mode, lobe, rng.next2D());
                    if (!s || s->transmitted != transmitted || lengthSquared(s->direction - axis) > 2 * cap)
                        continue;
                    sum += 1 / s->pdfForward;
                    squares += sqr(1.0 / s->pdfForward);
                }
                const double mean = sum / kSamples;
                const double error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
                const double solidAngle = 2 * std::numbers::pi * cap;
                EXPECT_NEAR(mean, solidAngle, 5 * error + 1e-3 * solidAngle) << cosine << transmitted;
                EXPECT_LT(error, 0.3 * solidAngle);
            }
}

TEST_P(RoughBsdf, StaysFiniteAtGrazingAngles) {
    const auto [type, u, v] = GetParam();
    const SurfaceInteraction si = flatInteraction();
    CounterRng rng(5);
    for (const BsdfPtr& bsdf :
         {conductor(type, u * 0.05f, v * 0.05f), dielectric(type, u * 0.05f, v * 0.05f)})
        for (const float cosine : {1e-2f, 1e-4f, 1e-7f, 1e-20f, 1e-38f, -1e-4f, -1e-20f})
            for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance})
                for (int i = 0; i < 500; ++i) {
                    const Vec3f known(std::sqrt(1 - cosine * cosine), 0, cosine);
                    const float lobe = rng.next1D();
                    const auto s = bsdf->sample(si, known, mode, lobe, rng.next2D());
                    if (s) {
                        ASSERT_TRUE(isFinite(s->weight) && isFinite(s->direction)) << cosine;
                        ASSERT_TRUE(std::isfinite(s->pdfForward) && std::isfinite(s->pdfReverse)) << cosine;
                    }
                    const BsdfEvaluation e = bsdf->evaluate(si, known, warp::squareToSphere(rng.next2D()));
                    ASSERT_TRUE(isFinite(e.value)) << cosine;
                    ASSERT_TRUE(std::isfinite(e.pdfLight) && std::isfinite(e.pdfEye)) << cosine;
                }
}

INSTANTIATE_TEST_SUITE_P(Roughnesses, RoughBsdf,
                         ::testing::Values(Roughness{MicrofacetType::Ggx, 0.02f, 0.02f},
                                           Roughness{MicrofacetType::Ggx, 0.3f, 0.3f},
                                           Roughness{MicrofacetType::Ggx, 1.0f, 0.25f},
                                           Roughness{MicrofacetType::Beckmann, 0.02f, 0.02f},
                                           Roughness{MicrofacetType::Beckmann, 0.15f, 0.6f},
                                           Roughness{MicrofacetType::Beckmann, 1.0f, 1.0f}));

TEST(Microfacet, ProjectedAreaOfTheNormalsIsOne) {
    // Integral of D(m) m.z, in polar angles; the step resolves alpha.
    for (const MicrofacetType type : {MicrofacetType::Ggx, MicrofacetType::Beckmann}) {
        const MicrofacetDistribution facets(type, 0.2f, 0.5f);
        constexpr int kN = 1000;
        double sum = 0;
        for (int i = 0; i < kN; ++i)
            for (int j = 0; j < 200; ++j) {
                const double theta = (i + 0.5) / kN * 0.5 * std::numbers::pi;
                const Vec3f m = direction(static_cast<float>(std::cos(theta)),
                                          static_cast<float>((j + 0.5) / 200 * 2 * std::numbers::pi));
                sum += facets.d(m) * m.z * std::sin(theta);
            }
        EXPECT_NEAR(sum * (0.5 * std::numbers::pi / kN) * (2 * std::numbers::pi / 200), 1, 2e-3);
    }
}

TEST(RoughConductor, HasTheValueOfTheTorranceSparrowModel) {
    // GGX, alpha 0.4, angles in one plane: everything in terms of angles and double precision.
    const double alpha = 0.4, thetaEye = 0.5, thetaLight = 0.9;
    const double thetaM = 0.5 * (thetaLight - thetaEye);  // the light leans the other way
    const auto g1 = [&](double t) {
        return 2 / (1 + std::sqrt(1 + alpha * alpha * std::pow(std::tan(t), 2)));
    };
    const double c2 = std::pow(std::cos(thetaM), 2), t2 = std::pow(std::tan(thetaM), 2);
    const double d = 1 / (std::numbers::pi * alpha * alpha * c2 * c2 * std::pow(1 + t2 / (alpha * alpha), 2));
    const double f =
        fresnelConductor(static_cast<float>(std::cos(thetaM + thetaEye)), Rgb(0.2f), Rgb(3.9f)).x;
    const double expected = f * d * g1(thetaEye) * g1(thetaLight) / (4 * std::cos(thetaEye));
    const Vec3f eye(static_cast<float>(-std::sin(thetaEye)), 0, static_cast<float>(std::cos(thetaEye)));
    const Vec3f light(static_cast<float>(std::sin(thetaLight)), 0, static_cast<float>(std::cos(thetaLight)));
    const BsdfEvaluation e = conductor(MicrofacetType::Ggx, 0.4f, 0.4f, Rgb(0.2f), Rgb(3.9f))
                                 ->evaluate(flatInteraction(), eye, light);
    EXPECT_NEAR(e.value.x, expected, 1e-5 * expected);
    EXPECT_NEAR(e.pdfLight, d * g1(thetaEye) / (4 * std::cos(thetaEye)), 1e-4);
    EXPECT_NEAR(e.pdfEye, d * g1(thetaLight) / (4 * std::cos(thetaLight)), 1e-4);
}

TEST(RoughConductor, LosesOnlyTheEnergyOfMultipleScattering) {
    // A perfect mirror (eta 0: Fresnel is 1), GGX. From the normal at alpha 1, cos^2 of the facets' angle is
    // uniform and what is left is the mean of G1(2 theta): the integral of 2 - 1/u over [1/2, 1], 1 - ln 2.
    const auto mirror = [](float a) { return conductor(MicrofacetType::Ggx, a, a, Rgb(0.0f), Rgb(1.0f)); };
    EXPECT_NEAR(albedoOf(*mirror(0.01f), {0, 0, 1}, TransportMode::Radiance), 1, 2e-3);
    EXPECT_NEAR(albedoOf(*mirror(1.0f), {0, 0, 1}, TransportMode::Radiance), 1 - std::numbers::ln2, 2e-3);
    EXPECT_NEAR(albedoOf(*mirror(1.0f), {0, 0, 1}, TransportMode::Importance), 1 - std::numbers::ln2, 1e-2);
}

TEST(RoughDielectric, SmoothGlassNeitherAbsorbsNorEmits) {
    for (const MicrofacetType type : {MicrofacetType::Ggx, MicrofacetType::Beckmann})
        for (const float cosine : {1.0f, 0.6f, 0.2f, -0.3f, -0.9f})
            for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance})
                EXPECT_NEAR(albedoOf(*dielectric(type, 0.01f, 0.01f), direction(cosine, 2), mode), 1, 0.01)
                    << cosine;
}

TEST(RoughDielectric, RefractsTowardSnellsDirection) {
    const float eta = 1.5f, sine = 0.6f;
    const BsdfPtr glass = dielectric(MicrofacetType::Beckmann, 0.001f, 0.001f, eta);
    const auto s =
        glass->sample(flatInteraction(), {sine, 0, 0.8f}, TransportMode::Radiance, 0.9f, {0.5f, 0.5f});
    ASSERT_TRUE(s && s->transmitted);
    EXPECT_NEAR(s->direction.x, -sine / eta, 2e-3);
    EXPECT_LT(s->direction.z, 0);
    EXPECT_FLOAT_EQ(s->eta, eta);
    EXPECT_NEAR(s->weight.x, 1 / (eta * eta), 2e-3);  // radiance shrinks on its way out of the glass
}

TEST(RoughDielectric, RefusesMatchedIndices) {
    RoughDielectricParameters p;
    p.eta = 1;
    EXPECT_THROW(makeRoughDielectric(p), Error);
}

TEST(Fresnel, AgreesWithKnownValues) {
    EXPECT_NEAR(fresnelDielectric(1, 1.5f), 0.04f, 1e-6);
    EXPECT_NEAR(fresnelDielectric(-1, 1.5f), 0.04f, 1e-6);
    EXPECT_FLOAT_EQ(fresnelDielectric(-0.5f, 1.5f), 1);  // beyond the critical angle
    // Brewster's angle: only the s part is reflected, ((n^2-1)/(n^2+1))^2 of it
    EXPECT_NEAR(fresnelDielectric(1 / std::sqrt(1 + 2.25f), 1.5f), 0.5f * sqr(1.25f / 3.25f), 1e-6);
    const Rgb metal = fresnelConductor(1, Rgb(1.5f, 0.2f, 1.0f), Rgb(0.0f, 3.0f, 0.0f));
    EXPECT_NEAR(metal.x, 0.04f, 1e-6);
    EXPECT_NEAR(metal.y, (0.64f + 9) / (1.44f + 9), 1e-5);  // ((n-1)^2 + k^2) / ((n+1)^2 + k^2)
    EXPECT_NEAR(metal.z, 0, 1e-6);
    // Mean over cosine-weighted directions, and the relation between its two sides, 1 - Fi = (1 - Fe) / eta^2
    double mean = 0;
    for (int i = 0; i < 10000; ++i)
        mean += fresnelDielectric(std::sqrt((static_cast<float>(i) + 0.5f) / 10000), 1.5f) / 10000;
    EXPECT_NEAR(fresnelDiffuseReflectance(1.5f), mean, 1e-3);
    EXPECT_NEAR(fresnelDiffuseReflectance(1 / 1.5f), 1 - (1 - mean) / 2.25, 2e-3);
}

}  // namespace
}  // namespace metrolux::core::test
