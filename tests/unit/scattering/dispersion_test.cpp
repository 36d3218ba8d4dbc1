/// Indices of refraction against published tables, colors of wavelengths, and models with dispersion.

#include "bsdf_checks.h"
#include "scattering/blend.h"
#include "scattering/dielectric.h"
#include "scattering/diffuse.h"
#include "scattering/mask.h"
#include "scattering/mixture.h"
#include "scattering/normal_map.h"
#include "scattering/principled.h"
#include "scattering/rough_dielectric.h"
#include "scattering/textures/constant.h"
#include "scattering/thin_dielectric.h"
#include "scattering/wavelength.h"
#include "scattering/without_null.h"

namespace metrolux::core {
namespace {

using test::flatInteraction;

double abbeNumber(const Dispersion& d) { return (d.at(kLineD) - 1) / (d.at(kLineF) - d.at(kLineC)); }

TEST(Dispersion, NamedMaterialsHaveThePublishedIndices) {
    // n_d and Abbe number. Glasses: SCHOTT's catalog; the others from refractiveindex.info.
    const struct {
        const char* name;
        double index, abbe;
    } published[] = {
        {"BK7", 1.51680, 64.17},      {"BAF10", 1.67003, 47.11},   {"FK51A", 1.48656, 84.47},
        {"F2", 1.62004, 36.37},       {"SF5", 1.67270, 32.21},     {"SF10", 1.72825, 28.41},
        {"SF11", 1.78472, 25.76},     {"LaSF9", 1.85025, 32.17},   {"fused silica", 1.45846, 67.82},
        {"sapphire", 1.76817, 72.31}, {"diamond", 2.41750, 55.30}, {"water", 1.33340, 55.7}};
    EXPECT_EQ(std::size(published), Dispersion::names().size());
    for (const auto& [name, index, abbe] : published) {
        SCOPED_TRACE(name);
        const auto found = Dispersion::named(name);
        ASSERT_TRUE(found);
        EXPECT_NEAR(found->at(kLineD), index, 2e-5);
        EXPECT_NEAR(abbeNumber(*found), abbe, 2e-3 * abbe);
        EXPECT_TRUE(found->varies());
    }
    // Other lines of SCHOTT's tables: F, C, h, r.
    const Dispersion bk7 = *Dispersion::named("N-BK7"), sf11 = *Dispersion::named("sf11");
    EXPECT_NEAR(bk7.at(486.1327), 1.52238, 1e-5);
    EXPECT_NEAR(bk7.at(656.2725), 1.51432, 1e-5);
    EXPECT_NEAR(bk7.at(404.6561), 1.53024, 1e-5);
    EXPECT_NEAR(bk7.at(706.5188), 1.51289, 1e-5);
    EXPECT_NEAR(sf11.at(486.1327), 1.80645, 1e-5);
    EXPECT_NEAR(sf11.at(656.2725), 1.77599, 1e-5);
    EXPECT_TRUE(Dispersion::named("Fused Silica"));
    EXPECT_TRUE(Dispersion::named("fused_silica"));
    EXPECT_FALSE(Dispersion::named("N-SF11")) << "another glass than SF11";
    EXPECT_FALSE(Dispersion::named("brick"));
}

TEST(Dispersion, AbbeNumberAndCauchy) {
    const Dispersion d = Dispersion::abbe(1.6, 30);
    EXPECT_NEAR(d.at(kLineD), 1.6, 1e-12);
    EXPECT_NEAR(abbeNumber(d), 30, 1e-9);
    EXPECT_GT(d.at(420), d.at(650));
    const Dispersion cauchy = Dispersion::cauchy(std::array{1.5, 0.004, 1e-4});
    EXPECT_NEAR(cauchy.at(500), 1.5 + 0.004 / 0.25 + 1e-4 / 0.0625, 1e-12);
    EXPECT_FALSE(Dispersion::cauchy(std::array{1.5, 0.0}).varies());
    // One term of Sellmeier's: n^2 = 1 + w^2 / (w^2 - 0.01).
    const Dispersion one = Dispersion::sellmeier(std::array{1.0}, std::array{0.01});
    EXPECT_NEAR(one.at(500), std::sqrt(1 + 0.25 / 0.24), 1e-12);
}

TEST(Dispersion, RefusesIndicesThatAreNone) {
    EXPECT_THROW(Dispersion::abbe(1.5, 0), Error);
    EXPECT_THROW(Dispersion::abbe(1.5, -20), Error);
    EXPECT_THROW(Dispersion::abbe(1.5, std::nan("")), Error);
    EXPECT_THROW(Dispersion::cauchy(std::array{1.5, -1.0}), Error);
    EXPECT_THROW(Dispersion::cauchy(std::array{1.0, 0.0, 0.0, 0.0}), Error);
    EXPECT_THROW(Dispersion::sellmeier(std::array{1.0}, std::array{0.25}), Error) << "infinite at 500 nm";
    EXPECT_THROW(Dispersion::sellmeier(std::array{-2.0}, std::array{0.01}), Error) << "imaginary";
    EXPECT_THROW(Dispersion::sellmeier(std::array{1.0, 2.0}, std::array{0.01}), Error);
}

TEST(Wavelength, TheMeanOfTheColorsIsWhite) {
    constexpr int kSteps = 200'000;
    std::array<double, 3> sum{};
    float last = 0, largest = 0, smallest = 0;
    double magnitude = 0;
    for (int i = 0; i < kSteps; ++i) {
        const Wavelength w = Wavelength::at((i + 0.5) / kSteps);
        for (size_t c = 0; c < 3; ++c) sum[c] += double(w.color[static_cast<int>(c)]) / kSteps;
        EXPECT_GE(w.nanometers, last);
        last = w.nanometers;
        largest = std::max(largest, maxComponent(w.color));
        smallest = std::min({smallest, w.color.x, w.color.y, w.color.z});
        magnitude = std::abs(double(w.color.x)) + std::abs(double(w.color.y)) + std::abs(double(w.color.z));
        EXPECT_GT(magnitude, 3);  // the same for all, but for steps of 1 nm
        EXPECT_LT(magnitude, 5);
    }
    for (const double s : sum) EXPECT_NEAR(s, 1, 1e-5);
    EXPECT_LT(largest, 4.5f);
    EXPECT_LT(smallest, -0.1f) << "colors of single wavelengths lie outside of Rec.709";
    EXPECT_FLOAT_EQ(Wavelength::at(0).nanometers, float(Wavelength::kFirst));
    EXPECT_LE(Wavelength::at(1 - 0x1p-53).nanometers, float(Wavelength::kLast));
}

TEST(Wavelength, PassesAreEvenlySpread) {
    // Independent wavelengths would leave 2.4 / sqrt(n) of a channel.
    for (uint64_t seed = 0; seed < 20; ++seed)
        for (const int n : {16, 64, 256}) {
            Rgb sum(0.0f);
            for (int pass = 0; pass < n; ++pass)
                sum += Wavelength::ofPass(seed, static_cast<uint32_t>(pass)).color;
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(sum[c] / static_cast<float>(n), 1, 6.0 / n) << seed << " " << n;
        }
    EXPECT_NE(Wavelength::ofPass(1, 0).nanometers, Wavelength::ofPass(2, 0).nanometers);
}

const float kBlue = 440, kRed = 650;
const Dispersion& flint() {
    static const Dispersion d = *Dispersion::named("SF11");
    return d;
}
SurfaceInteraction interactionAt(float nanometers) {
    SurfaceInteraction si = flatInteraction();
    si.wavelength = nanometers;
    return si;
}

/// A model with dispersion is at each wavelength the one with that index.
void expectIndexOf(const Bsdf& dispersive, const std::function<BsdfPtr(float eta)>& make) {
    CounterRng rng(3);
    EXPECT_TRUE(dispersive.isDispersive());
    for (const float nanometers : {0.0f, kBlue, kRed}) {
        const SurfaceInteraction si = interactionAt(nanometers);
        const BsdfPtr plain =
            make(static_cast<float>(flint().at(nanometers > 0 ? double(nanometers) : kLineD)));
        EXPECT_FALSE(plain->isDispersive());
        for (int i = 0; i < 200; ++i) {
            const Vec3f known =
                normalize(Vec3f(rng.next1D() - 0.5f, rng.next1D() - 0.5f, rng.next1D() - 0.5f));
            const float uLobe = rng.next1D();
            const Vec2f u = rng.next2D();
            const auto mode = i % 2 ? TransportMode::Radiance : TransportMode::Importance;
            const auto a = dispersive.sample(si, known, mode, uLobe, u),
                       b = plain->sample(si, known, mode, uLobe, u);
            ASSERT_EQ(a.has_value(), b.has_value());
            if (!a) continue;
            EXPECT_EQ(a->direction, b->direction);
            EXPECT_EQ(a->weight, b->weight);
            EXPECT_EQ(a->pdfForward, b->pdfForward);
            EXPECT_EQ(a->pdfReverse, b->pdfReverse);
            const BsdfEvaluation x = dispersive.evaluate(si, known, a->direction),
                                 y = plain->evaluate(si, known, a->direction);
            EXPECT_EQ(x.value, y.value);
            EXPECT_EQ(x.pdfEye, y.pdfEye);
            const NullLobe p = dispersive.nullLobe(si, known), q = plain->nullLobe(si, known);
            EXPECT_EQ(p.probability, q.probability);
        }
    }
}

BsdfPtr glass() { return makeDielectric({RelativeIndex(flint(), 1)}); }

TEST(DispersiveBsdf, HasTheIndexOfTheWavelength) {
    expectIndexOf(*glass(), [](float eta) { return makeDielectric({eta}); });
    expectIndexOf(*makeThinDielectric({RelativeIndex(flint(), 1)}),
                  [](float eta) { return makeThinDielectric({eta}); });
    const auto rough = [](const RelativeIndex& eta) {
        RoughDielectricParameters p;
        p.eta = eta;
        return makeRoughDielectric(p);
    };
    expectIndexOf(*rough(RelativeIndex(flint(), 1)), rough);
    const auto principled = [](const RelativeIndex& eta) {
        PrincipledParameters p;
        p.eta = eta;
        p.specTrans = p.roughness = makeConstantTexture(Rgb(0.6f));
        p.specTint = p.clearcoat = makeConstantTexture(Rgb(0.5f));
        return makePrincipled(p);
    };
    expectIndexOf(*principled(RelativeIndex(flint(), 1)), principled);
}

TEST(DispersiveBsdf, WrappersSaySo) {
    const BsdfPtr paint = makeDiffuse({}), sheet = makeThinDielectric({RelativeIndex(flint(), 1)});
    const TexturePtr half = makeConstantTexture(Rgb(0.5f));
    EXPECT_TRUE(makeMask({half, glass()})->isDispersive());
    EXPECT_FALSE(makeMask({half, paint})->isDispersive());
    EXPECT_TRUE(makeBlend({half, paint, glass()})->isDispersive());
    EXPECT_TRUE(makeMixture({{{0.5f, paint}, {0.5f, glass()}}})->isDispersive());
    EXPECT_TRUE(makeNormalMap({half, glass(), {}})->isDispersive());
    EXPECT_TRUE(withoutNull(sheet)->isDispersive());
    // What refracts nothing, or has one index after all.
    PrincipledParameters opaque;
    opaque.eta = RelativeIndex(flint(), 1);
    EXPECT_FALSE(makePrincipled(opaque)->isDispersive());
    EXPECT_FALSE(
        makeDielectric({RelativeIndex(Dispersion::cauchy(std::array{1.5, 0.0}), 1)})->isDispersive());
}

TEST(DispersiveBsdf, ARoughSurfaceRefusesTheIndexOfItsSurroundings) {
    RoughDielectricParameters p;
    p.eta = RelativeIndex(flint(), static_cast<float>(flint().at(500)));
    EXPECT_THROW(makeRoughDielectric(p), Error);
    PrincipledParameters principled;
    principled.eta = p.eta;
    principled.specTrans = makeConstantTexture(Rgb(1.0f));
    EXPECT_THROW(makePrincipled(principled), Error);
}

}  // namespace
}  // namespace metrolux::core
