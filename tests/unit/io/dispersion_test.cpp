/// Dispersion in scene files: which index a material has at a wavelength, and what is refused.

#include "gltf_support.h"
#include "pbrt_support.h"
#include "scattering/refractive_index.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::HasSubstr;

/// Relative index at a wavelength (0: none), by the reflectance of a smooth interface at normal incidence.
double indexOf(const Bsdf& bsdf, double nanometers) {
    SurfaceInteraction si;
    si.ns = si.ng = Vec3f(0, 0, 1);
    si.s = Vec3f(1, 0, 0);
    si.wavelength = static_cast<float>(nanometers);
    // By Snell's law: a direction at 30 degrees, refracted.
    const Vec3f known(0.5f, 0, std::sqrt(0.75f));
    const auto s = bsdf.sample(si, known, TransportMode::Radiance, kOneMinusEpsilon, Vec2f(0.5f));
    return s && s->transmitted ? 0.5 / std::abs(double(s->direction.x)) : 0;
}

BsdfPtr onlyBsdf(const SceneParts& parts) { return parts.shapes.at(0)->bsdf; }

SceneParts withGlass(const std::string& properties, const std::string& type = "dielectric") {
    const TemporaryFolder folder;
    return loadScene(
        folder.write("scene.xml", underSky(quad("<bsdf type=\"" + type + "\">" + properties + "</bsdf>"))),
        {});
}

std::string text(const std::string& name, const std::string& value) {
    return "<string name=\"" + name + "\" value=\"" + value + "\"/>";
}
std::string number(const std::string& name, const std::string& value) {
    return "<float name=\"" + name + "\" value=\"" + value + "\"/>";
}
const std::string kVacuum = number("ext_ior", "1");

TEST(DispersionInScenes, OfMitsubasModels) {
    const struct {
        std::string properties;
        double atBlue, atRed, atLineD;
    } cases[] = {
        {text("glass", "SF11"), 1.80645, 1.77599, 1.78472},
        {text("glass", "n-bk7"), 1.52238, 1.51432, 1.51680},
        {text("cauchy", "1.5, 0.004"), 1.5 + 0.004 / 0.236325, 1.5 + 0.004 / 0.430694,
         1.5 + 0.004 / 0.345229},
        {text("sellmeier", "1.03961212, 0.231792344, 1.01046945, 0.00600069867, 0.0200179144, 103.560653"),
         1.52238, 1.51432, 1.51680},
        {number("int_ior", "1.62004") + number("abbe", "36.37"), 1.631957, 1.614909, 1.62004},
    };
    for (const auto& c : cases) {
        const SceneParts parts = withGlass(c.properties + kVacuum);
        const BsdfPtr bsdf = onlyBsdf(parts);
        EXPECT_TRUE(bsdf->isDispersive());
        EXPECT_NEAR(indexOf(*bsdf, kLineF), c.atBlue, 2e-5) << c.properties;
        EXPECT_NEAR(indexOf(*bsdf, kLineC), c.atRed, 2e-5) << c.properties;
        EXPECT_NEAR(indexOf(*bsdf, 0), c.atLineD, 2e-5) << c.properties;
    }
    EXPECT_NEAR(indexOf(*onlyBsdf(withGlass(text("glass", "SF11") + number("ext_ior", "1.3"))), kLineF),
                1.80645 / 1.3, 2e-5);
    for (const char* type : {"thindielectric", "roughdielectric"})
        EXPECT_TRUE(onlyBsdf(withGlass(text("glass", "diamond"), type))->isDispersive());
    EXPECT_TRUE(
        onlyBsdf(withGlass(number("abbe", "40") + number("spec_trans", "1"), "principled"))->isDispersive());
}

TEST(DispersionInScenes, WithoutAnyAllStaysAsItWas) {
    EXPECT_FALSE(onlyBsdf(withGlass(text("int_ior", "bk7")))->isDispersive());
    // Cauchy's A alone is a plain dielectric, to the bit.
    const TemporaryFolder folder;
    const auto image = [&](const std::string& properties) {
        const std::string body =
            "<shape type=\"sphere\"><float name=\"radius\" value=\"0.3\"/><bsdf type=\"dielectric\">" +
            properties + "</bsdf></shape>" + quad(kHalf);
        return RenderableScene(folder.write("scene.xml", underSky(body)), {}).render("vcm", 4, 1);
    };
    EXPECT_EQ(image(text("cauchy", "1.5, 0")), image(number("int_ior", "1.5")));
    EXPECT_NE(image(text("cauchy", "1.5, 0.01")), image(number("int_ior", "1.5")));
}

TEST(DispersionInScenes, OfPbrtsNamedGlasses) {
    const auto made = [](const std::string& material) {
        return onlyBsdf(
            loadedPbrt(pbrtScene("LightSource \"infinite\"\nMaterial " + material + "\nShape \"sphere\"\n")));
    };
    const struct {
        const char *name, *glass;
    } names[] = {{"glass-BK7", "BK7"},     {"glass-F11", "SF11"},    {"glass-SF10", "SF10"},
                 {"glass-FK51A", "FK51A"}, {"glass-BAF10", "BAF10"}, {"glass-LASF9", "LaSF9"},
                 {"glass-F5", "SF5"}};
    for (const auto& [name, glass] : names) {
        const BsdfPtr bsdf = made(std::string("\"dielectric\" \"spectrum eta\" \"") + name + "\"");
        EXPECT_NEAR(indexOf(*bsdf, 450), Dispersion::named(glass)->at(450), 2e-5) << name;
    }
    EXPECT_TRUE(
        made("\"dielectric\" \"spectrum eta\" \"glass-BK7\" \"float roughness\" 0.2")->isDispersive());
    EXPECT_TRUE(made("\"thindielectric\" \"spectrum eta\" \"glass-BK7\"")->isDispersive());
    EXPECT_FALSE(made("\"dielectric\" \"float eta\" 1.5")->isDispersive());
}

TEST(DispersionInScenes, OfGltfsExtension) {
    const auto made = [](double dispersion, bool volume) {
        GltfMaker m;
        Json material{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
                      {"extensions",
                       {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                        {"KHR_materials_dispersion", {{"dispersion", dispersion}}}}}};
        if (volume) material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
        m.node({{"mesh", m.quad(material)}});
        m.camera();
        return loaded(m);
    };
    const SceneParts parts = made(0.5, true);
    EXPECT_TRUE(onlyBsdf(parts)->isDispersive());
    EXPECT_FALSE(onlyBsdf(made(0, true))->isDispersive());
    const SceneParts thin = made(0.5, false);
    EXPECT_FALSE(onlyBsdf(thin)->isDispersive());
    EXPECT_THAT(thin.warnings, testing::Contains(HasSubstr("KHR_materials_dispersion has no effect")));
    EXPECT_THAT(errorOf([&] { made(-1, true); }), HasSubstr("found \"dispersion\" -1"));
}

struct Bad {
    std::string name, properties;
    std::vector<std::string> expected;
    std::string type = "dielectric";
};
const std::vector<Bad> kBad = {
    {"two_of_them", text("glass", "BK7") + number("abbe", "30"), {"found \"glass\" as well as \"abbe\""}},
    {"glass_and_index",
     text("glass", "BK7") + number("int_ior", "1.5"),
     {"found \"int_ior\" as well as \"glass\""}},
    {"unknown_glass", text("glass", "SF99"), {"\"glass\"", "found the material \"SF99\"", "SF11", "diamond"}},
    {"abbe_of_zero", number("abbe", "0"), {"\"abbe\"", "found the Abbe number 0"}},
    {"negative_abbe", number("abbe", "-3"), {"found the Abbe number -3", "above zero"}},
    {"four_of_cauchy", text("cauchy", "1, 0, 0, 0"), {"\"cauchy\"", "found 4 coefficients", "one to three"}},
    {"cauchy_below_zero",
     text("cauchy", "1.5, -1"),
     {"index of refraction at 380 nm", "expected a positive number"}},
    {"cauchy_that_is_text", text("cauchy", "high"), {"\"cauchy\"", "high"}},
    {"odd_sellmeier", text("sellmeier", "1, 2, 3"), {"\"sellmeier\"", "found 3 coefficients"}},
    {"resonance_in_the_visible", text("sellmeier", "1, 0.25"), {"infinite at 500 nm"}},
    {"rough_without_contrast", text("cauchy", "0.9, 0.03") + kVacuum, {"other than 1"}, "roughdielectric"},
    {"of_plastic", text("glass", "BK7"), {"\"glass\""}, "plastic"},
};

class BadDispersion : public testing::TestWithParam<Bad> {};

TEST_P(BadDispersion, IsRefusedWithItsPlace) {
    const Bad& bad = GetParam();
    const std::string message = errorOf([&] { withGlass(bad.properties, bad.type); });
    EXPECT_THAT(message, HasSubstr("scene.xml:"));
    EXPECT_THAT(message, HasSubstr("<bsdf type=\"" + bad.type + "\">"));
    for (const std::string& part : bad.expected) EXPECT_THAT(message, HasSubstr(part));
}

INSTANTIATE_TEST_SUITE_P(Dispersion, BadDispersion, testing::ValuesIn(kBad),
                         [](const auto& bad) { return bad.param.name; });

}  // namespace
}  // namespace metrolux::core::test
