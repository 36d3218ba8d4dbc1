/// The models without microfacets, and the wrappers, through the common checks.
#include "bsdf_checks.h"
#include "scattering/blend.h"
#include "scattering/bump_map.h"
#include "scattering/conductor.h"
#include "scattering/dielectric.h"
#include "scattering/diffuse.h"
#include "scattering/ior_table.h"
#include "scattering/mask.h"
#include "scattering/normal_map.h"
#include "scattering/null_bsdf.h"
#include "scattering/rough_conductor.h"
#include "scattering/textures/bitmap_texture.h"
#include "scattering/textures/constant.h"
#include "scattering/thin_dielectric.h"
#include "scattering/two_sided.h"

namespace metrolux::core {
namespace {

using test::BsdfCase;
using test::checkBsdf;
using test::flatInteraction;

TexturePtr gray(float value) { return makeConstantTexture(Rgb(value)); }
TexturePtr color(float r, float g, float b) { return makeConstantTexture(Rgb(r, g, b)); }
TexturePtr normalTexture(const Vec3f& n) {
    const Vec3f unit = normalize(n);
    return color(0.5f * unit.x + 0.5f, 0.5f * unit.y + 0.5f, 0.5f * unit.z + 0.5f);
}
BsdfPtr metal(float alpha) {
    RoughConductorParameters p;
    p.eta = color(1.66f, 0.88f, 0.52f);
    p.k = color(9.2f, 6.3f, 4.8f);
    p.alphaU = gray(alpha);
    p.alphaV = gray(0.5f * alpha);
    return makeRoughConductor(p);
}
BsdfPtr glass() { return makeDielectric({1.5f, nullptr, nullptr}); }
BsdfPtr paint() { return makeDiffuse({color(0.2f, 0.9f, 0.5f)}); }
/// The known lobe with the given sign of transmission, or nothing within 1000 tries.
std::optional<BsdfSample> findLobe(const Bsdf& bsdf, const Vec3f& known, TransportMode mode,
                                   bool transmitted) {
    CounterRng rng(5);
    for (int i = 0; i < 1000; ++i) {
        const float uLobe = rng.next1D();
        const auto s = bsdf.sample(flatInteraction(), known, mode, uLobe, rng.next2D());
        if (s && s->transmitted == transmitted) return s;
    }
    return std::nullopt;
}

TEST(SmoothBsdf, Diffuse) {
    checkBsdf({"diffuse", paint()});
    checkBsdf({"black", makeDiffuse({gray(0)})});
    const BsdfEvaluation e =
        makeDiffuse({nullptr})->evaluate(flatInteraction(), Vec3f(0, 0, 1), normalize(Vec3f(1, 0, 1)));
    EXPECT_FLOAT_EQ(e.value.x, 0.5f * kInvPi * std::sqrt(0.5f));
}

TEST(SmoothBsdf, Dielectric) {
    checkBsdf({"glass", glass()});
    checkBsdf({"bubble", makeDielectric({1 / 1.5f, nullptr, nullptr})});
    checkBsdf({"diamond, tinted", makeDielectric({2.419f, color(1, 0.5f, 0.2f), color(0.1f, 0.8f, 0.4f)})});
    checkBsdf({"no reflection", makeDielectric({1.5f, gray(0), nullptr})});
    checkBsdf({"index-matched", makeDielectric({1, nullptr, nullptr})});
    EXPECT_THROW(makeDielectric({0, nullptr, nullptr}), Error);
}

TEST(SmoothBsdf, DielectricByHand) {
    const float f = sqr(0.5f / 2.5f);
    const Vec3f up(0, 0, 1);
    const auto eye = findLobe(*glass(), up, TransportMode::Radiance, true);
    ASSERT_TRUE(eye);
    EXPECT_NEAR(eye->pdfForward, 1 - f, 1e-6);
    EXPECT_NEAR(eye->weight.x, 1 / sqr(1.5f), 1e-6) << "radiance is scaled";
    const auto light = findLobe(*glass(), up, TransportMode::Importance, true);
    ASSERT_TRUE(light);
    EXPECT_NEAR(light->weight.x, 1, 1e-6) << "importance is not";
    EXPECT_FLOAT_EQ(light->eta, 1.5f);
    // Snell, from inside: sin 30 degrees * 1.5 = 0.75
    const auto oblique = findLobe(*glass(), Vec3f(0.5f, 0, -std::sqrt(0.75f)), TransportMode::Radiance, true);
    ASSERT_TRUE(oblique);
    EXPECT_NEAR(oblique->direction.x, -0.75f, 1e-6);
    EXPECT_NEAR(oblique->direction.z, std::sqrt(1 - sqr(0.75f)), 1e-6);
    EXPECT_FALSE(findLobe(*glass(), normalize(Vec3f(1, 0, -1)), TransportMode::Radiance, true))
        << "total reflection";
}

TEST(SmoothBsdf, ThinDielectric) {
    checkBsdf({"window", makeThinDielectric({1.5f, nullptr, nullptr})});
    checkBsdf({"tinted window", makeThinDielectric({1.8f, gray(0.7f), color(0.1f, 0.8f, 0.4f)})});
    const auto s = findLobe(*makeThinDielectric({1.5f, nullptr, nullptr}), Vec3f(0, 0, 1),
                            TransportMode::Radiance, true);
    ASSERT_TRUE(s);
    EXPECT_NEAR(s->pdfForward, 1 - 2 * 0.04f / 1.04f, 1e-6);
    EXPECT_NEAR(s->weight.x, 1, 1e-6);
}

TEST(SmoothBsdf, Conductor) {
    checkBsdf({"mirror", makeConductor({})});
    checkBsdf({"gold", makeConductor({color(0.143f, 0.375f, 1.44f), color(3.98f, 2.39f, 1.6f), gray(0.8f)})});
    const auto s = findLobe(*makeConductor({}), Vec3f(0, 0.6f, 0.8f), TransportMode::Importance, false);
    ASSERT_TRUE(s);
    EXPECT_EQ(s->direction, Vec3f(0, -0.6f, 0.8f));
    EXPECT_NEAR(s->weight.y, 1, 1e-6);
}

TEST(SmoothBsdf, Null) { checkBsdf({"null", makeNullBsdf()}); }

TEST(WrapperBsdf, TwoSided) {
    checkBsdf({"two colors", makeTwoSided({paint(), makeDiffuse({gray(0.8f)})})});
    checkBsdf({"metal on both sides", makeTwoSided({metal(0.3f), nullptr})});
    checkBsdf({"mirror behind", makeTwoSided({paint(), makeConductor({})})});
    EXPECT_THROW(makeTwoSided({glass(), nullptr}), Error);
}

TEST(WrapperBsdf, Mask) {
    checkBsdf({"veil", makeMask({gray(0.3f), paint()})});
    checkBsdf({"mirror with holes", makeMask({gray(0.6f), makeTwoSided({makeConductor({}), nullptr})})});
    checkBsdf({"not there", makeMask({gray(0), paint()})});
    checkBsdf({"opaque", makeMask({gray(1.5f), paint()})});
}

TEST(WrapperBsdf, Blend) {
    checkBsdf({"paint and metal", makeBlend({gray(0.3f), paint(), metal(0.3f)})});
    checkBsdf({"paint and glass", makeBlend({gray(0.7f), paint(), glass()})});
    checkBsdf({"first only", makeBlend({gray(0), paint(), glass()})});
    checkBsdf({"second only", makeBlend({gray(1), glass(), paint()})});
    const BsdfPtr all = makeBlend({gray(0.25f), makeDiffuse({gray(0)}), makeDiffuse({gray(1)})});
    EXPECT_NEAR(all->evaluate(flatInteraction(), Vec3f(0, 0, 1), Vec3f(0, 0, 1)).value.x, 0.25f * kInvPi,
                1e-6)
        << "the weight is that of the second model";
}

/// The perturbed models are not reciprocal (the frame follows the eye, the shadowing the light), and their
/// albedo for light subpaths is not bounded in the original frame.
void checkPerturbed(const std::string& name, const BsdfPtr& bsdf) { checkBsdf({name, bsdf, false, false}); }

TEST(PerturbedBsdf, NormalMap) {
    const Vec3f gentle(0.2f, -0.1f, 1), steep(-0.7f, 0.5f, 0.6f);
    checkPerturbed("gentle, paint", makeNormalMap({normalTexture(gentle), paint(), {}}));
    checkPerturbed("steep, paint", makeNormalMap({normalTexture(steep), paint(), {}}));
    checkPerturbed("steep, metal", makeNormalMap({normalTexture(steep), metal(0.4f), {}}));
    checkPerturbed("steep, not flipped", makeNormalMap({normalTexture(steep), paint(), {false, false}}));
    checkPerturbed("two-sided", makeNormalMap({normalTexture(gentle), makeTwoSided({paint(), nullptr}), {}}));
}

/// A tilted mirror or glass is an ordinary one in another frame: the probabilities seen from both ends must
/// agree, and the weights be those of the nested model.
TEST(PerturbedBsdf, TiltedDelta) {
    const Vec3f steep(-0.7f, 0.5f, 0.6f);
    checkPerturbed("glass", makeNormalMap({normalTexture(steep), glass(), {false, false}}));
    checkPerturbed("mirror", makeNormalMap({normalTexture(steep), makeConductor({}), {false, false}}));
    checkPerturbed("glass, flipped", makeNormalMap({normalTexture(steep), glass(), {true, false}}));
    checkPerturbed("mirror, flipped",
                   makeNormalMap({normalTexture(steep), makeConductor({}), {true, false}}));
}

TEST(PerturbedBsdf, TiltedGlassHasTheWeightsOfGlass) {
    const Vec3f n = normalize(Vec3f(-0.7f, 0.5f, 1.0f)), known = normalize(Vec3f(0.1f, 0.2f, 0.9f));
    const Frame frame = Frame::fromNormalAndTangent(n, Vec3f(1, 0, 0));
    for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance}) {
        const auto tilted =
            findLobe(*makeNormalMap({normalTexture(n), glass(), {false, false}}), known, mode, true);
        const auto plain = findLobe(*glass(), frame.toLocal(known), mode, true);
        ASSERT_TRUE(tilted && plain);
        EXPECT_NEAR(tilted->weight.x, plain->weight.x, 1e-4);
        EXPECT_NEAR((tilted->direction - frame.toWorld(plain->direction)).length(), 0, 1e-4);
    }
}

TEST(PerturbedBsdf, FlatMapChangesNothing) {
    const BsdfPtr plain = metal(0.4f), mapped = makeNormalMap({normalTexture({0, 0, 1}), plain, {}});
    const SurfaceInteraction si = flatInteraction();
    const Vec3f a = normalize(Vec3f(0.3f, 0.2f, 0.8f)), b = normalize(Vec3f(-0.5f, 0.1f, 0.4f));
    const BsdfEvaluation e = plain->evaluate(si, a, b), m = mapped->evaluate(si, a, b);
    EXPECT_NEAR(e.value.x, m.value.x, 1e-5);
    EXPECT_NEAR(e.pdfEye, m.pdfEye, 1e-5);
    EXPECT_NEAR(e.pdfLight, m.pdfLight, 1e-5);
}

TEST(PerturbedBsdf, BumpMapTiltsAgainstTheSlope) {
    // Height grows with u: slope 1 in u, so that the normal is (-1, 0, 1) / sqrt 2.
    auto pixels = std::make_shared<std::vector<float>>(std::vector<float>{0, 0.5f, 0, 0.5f});
    BitmapTextureParameters ramp;
    ramp.width = ramp.height = 2;
    ramp.channels = 1;
    ramp.pixels = pixels;
    BumpMapParameters p;
    p.height = makeBitmapTexture(ramp);
    p.nested = makeDiffuse({gray(1)});
    p.options = {false, false};
    const BsdfPtr bump = makeBumpMap(p);
    const SurfaceInteraction si = flatInteraction({0.5f, 0.5f});
    EXPECT_NEAR(bump->evaluate(si, Vec3f(0, 0, 1), normalize(Vec3f(-1, 0, 1))).value.x, kInvPi, 1e-5);
    p.options = {};
    checkPerturbed("bump", makeBumpMap(p));
}

TEST(IorTable, Names) {
    EXPECT_FLOAT_EQ(*namedIor("BK7"), 1.5046f);
    EXPECT_FLOAT_EQ(*namedIor("acrylic glass"), 1.49f);
    EXPECT_FALSE(namedIor("glas"));
    EXPECT_EQ(namedConductor("none")->k, Rgb(1.0f));
    EXPECT_NEAR(namedConductor("Au")->eta.z, 1.44248f, 1e-5);
    EXPECT_EQ(namedConductor("W_palik")->k, namedConductor("W")->k);
    EXPECT_EQ(namedConductor("Na")->k, namedConductor("Na_palik")->k);
    EXPECT_FALSE(namedConductor("Unobtainium"));
}

}  // namespace
}  // namespace metrolux::core
