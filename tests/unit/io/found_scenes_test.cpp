/// What scenes that were found elsewhere have, and their own Mitsuba reads: each kind with its value.

#include "cases_support.h"

#include <gmock/gmock.h>

#include <numbers>

namespace metrolux::core::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kTau = 2 * std::numbers::pi;

SceneParts load(const std::string& body, const std::string& version = "3.0.0") {
    const TemporaryFolder folder;
    return loadScene(folder.write("scene.xml", underSky(body, version)), {});
}
std::string error(const std::string& body, const std::string& version = "3.0.0") {
    return errorOf([&] { load(body, version); });
}
Rgb picture(const std::string& body, const std::string& version = "3.0.0") {
    const TemporaryFolder folder;
    return meanOf(render(folder.write("scene.xml", underSky(body, version))));
}

TEST(FoundScenes, UnknownAttributesWarnIn06) {
    const std::string body = R"(<shape type="sphere"><float name="radius" value="2" comment="x"/></shape>)";
    const SceneParts parts = load(body, "0.6.0");
    EXPECT_THAT(parts.warnings, ElementsAre(AllOf(HasSubstr("scene.xml:"), HasSubstr("\"comment\""))));
    EXPECT_NEAR(parts.shapes[0]->area(), 2 * kTau * 4, 1e-3);
    EXPECT_THAT(error(body), HasSubstr("\"comment\""));
    // What an included file lets pass is its own version's.
    const TemporaryFolder folder;
    folder.write("old.xml", scene(R"(<shape type="sphere" note="x"/>)", "0.6.0"));
    EXPECT_THAT(errorOf([&] {
                    loadScene(folder.write("scene.xml", underSky(R"(<include filename="old.xml"/><shape
type="sphere" note="x"/>)")),
                              {});
                }),
                AllOf(HasSubstr("scene.xml:"), HasSubstr("\"note\"")));
}

/// Stretched by four along y, after a turn of 45 degrees.
const std::string kTurned = R"(<rotate z="1" angle="45"/><scale y="4"/>)";
std::string placed(const std::string& type, const std::string& steps, const std::string& version,
                   const std::string& more = "") {
    return fmt::format(R"(<shape type="{}"><transform name="{}">{}</transform>{}</shape>)", type,
                       version[0] == '0' ? "toWorld" : "to_world", steps, more);
}

TEST(FoundScenes, SpheresStayRound) {
    const auto radius = [](const std::string& steps, const std::string& version) {
        const SceneParts parts = load(placed("sphere", steps, version), version);
        EXPECT_THAT(parts.warnings, Contains(HasSubstr("unequal scales"))) << version;
        return std::sqrt(double(parts.shapes[0]->area()) / (2 * kTau));
    };
    EXPECT_NEAR(radius(R"(<scale x="3" y="2" z="1"/>)", "3.0.0"), 3, 1e-4);
    EXPECT_NEAR(radius(R"(<scale x="3" y="2" z="1"/>)", "0.6.0"), 3, 1e-4);
    // The symmetric factor of the polar decomposition has (1 + 4) / 2 on its diagonal; the x axis becomes
    // (1, 4) / sqrt 2.
    EXPECT_NEAR(radius(kTurned, "3.0.0"), 2.5, 1e-4);
    EXPECT_NEAR(radius(kTurned, "0.6.0"), std::sqrt(8.5), 1e-4);
    Vec3f lower, upper;
    load(placed("sphere", R"(<scale y="2"/><translate x="5"/>)", "3.0.0",
                R"(<point name="center" x="0" y="1" z="0"/>)"))
        .shapes[0]
        ->bounds(lower, upper);
    EXPECT_LT(((lower + upper) * 0.5f - Vec3f(5, 2, 0)).length(), 1e-4f);
    EXPECT_THAT(load(placed("sphere", R"(<scale value="2"/>)", "3.0.0")).warnings, IsEmpty());
}

TEST(FoundScenes, CylindersStayRound) {
    const auto area = [](const std::string& steps, const std::string& version, const std::string& more = "") {
        return double(load(placed("cylinder", steps, version, more), version).shapes[0]->area());
    };
    EXPECT_NEAR(area(R"(<scale x="1" y="2" z="3"/>)", "3.0.0"), kTau * 1 * 3, 1e-3);
    EXPECT_NEAR(area(R"(<scale x="1" y="2" z="3"/>)", "0.6.0"), kTau * 1 * 3, 1e-3);
    EXPECT_NEAR(area(R"(<scale z="3"/>)", "3.0.0"), kTau * 3, 1e-3);
    // Along an axis that the shear leaves alone.
    EXPECT_NEAR(area(R"(<matrix value="1 0 0.5 0 0 1 0 0 0 0 1 0 0 0 0 1"/>)", "0.6.0"),
                kTau * std::sqrt(1.25), 1e-3);
}

TEST(FoundScenes, ASunWithoutSizeIsADirectionalLight) {
    const auto suns = [](const std::string& type, const char* scale) {
        return load(fmt::format(R"(<shape type="sphere"/><emitter type="{}"><vector name="sunDirection" x="0"
y="1" z="0.2"/>{}</emitter>)",
                                type, scale),
                    "0.6.0")
            .lights;
    };
    const std::string zero = R"(<float name="sunRadiusScale" value="0"/>)";
    const TemporaryFolder folder;
    const auto flux = [&](const std::string& more) {
        // A white floor below nothing but the sun.
        const auto file = folder.write("scene.xml", scene(fmt::format(R"(<integrator type="direct"/>
<sensor type="perspective"><float name="fov" value="20"/><transform name="toWorld"><lookat origin="0,2,0" target="0,0,0" up="0,0,1"/>
</transform><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/><rfilter type="box"/></film>
</sensor><shape type="rectangle"><transform name="toWorld"><rotate x="1" angle="-90"/></transform></shape>
<emitter type="sun"><vector name="sunDirection" x="0" y="1" z="0.2"/>{}</emitter>)",
                                                                      more),
                                                          "0.6.0"));
        return meanOf(render(file));
    };
    const Rgb point = flux(zero), disc = flux("");
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(point[k], disc[k], 0.01f * disc[k]);
    EXPECT_TRUE(loadScene(folder.path() / "scene.xml", {}).lights.size() == 1);
    EXPECT_THAT(error(R"(<emitter type="sun"><float name="sunRadiusScale" value="-1"/></emitter>)", "0.6.0"),
                HasSubstr("sun_radius_scale"));
    EXPECT_THAT(errorOf([&] { suns("sky", zero.c_str()); }), HasSubstr("second environment emitter"));
}

TEST(FoundScenes, ABeamIsNotWiderThanItsCone) {
    for (const char* version : {"0.6.0", "3.0.0"}) {
        const bool old = version[0] == '0';
        EXPECT_THAT(
            load(fmt::format(R"(<shape type="sphere"/><emitter type="spot"><float name="{}" value="30"/>
<float name="{}" value="20"/></emitter>)",
                             old ? "beamWidth" : "beam_width", old ? "cutoffAngle" : "cutoff_angle"),
                 version)
                .warnings,
            ElementsAre(HasSubstr("is cut at")));
    }
}

TEST(FoundScenes, TheLastOfSeveralBsdfsHoldsIn06) {
    const std::string two = diffuse(R"(<rgb name="reflectance" value="0.1"/>)") +
                            diffuse(R"(<rgb name="reflectance" value="0.6"/>)");
    expectGray(picture(quad(two), "0.6.0"), 0.6f);
    EXPECT_THAT(error(quad(two)), HasSubstr("expected one at most"));
}

TEST(FoundScenes, TheMaterialOfAMetalStandsBehindWhatIsGivenIn06) {
    const auto metal = [](const std::string& parameters, const std::string& version) {
        return picture(quad("<bsdf type=\"conductor\">" + parameters + "</bsdf>"), version);
    };
    const std::string given = R"(<rgb name="eta" value="0 0 0"/>)";
    EXPECT_THAT(
        load(quad("<bsdf type=\"conductor\">" + given + R"(<string name="material" value="Au"/></bsdf>)"),
             "0.6.0")
            .warnings,
        IsEmpty());
    // Without absorption, or with an index of zero, a metal is a mirror.
    expectGray(metal(given, "0.6.0"), 1);
    expectGray(metal(R"(<string name="material" value="Au"/>)" + given, "0.6.0"), 1);
    EXPECT_LT(
        metal(R"(<string name="material" value="Au"/><rgb name="eta" value="1.5 1.5 1.5"/>)", "0.6.0").x,
        0.95f);
    EXPECT_THAT(errorOf([&] { metal(R"(<string name="material" value="Au"/>)" + given, "3.0.0"); }),
                HasSubstr("expected one of the two"));
}

TEST(FoundScenes, SheetsPolarizeNothing) {
    const auto sheet = [](const std::string& type, const std::string& more = "") {
        return picture(quad("<bsdf type=\"" + type + "\">" + more + "</bsdf>"));
    };
    expectGray(sheet("polarizer"), 0.5f);
    expectGray(
        sheet("polarizer", R"(<spectrum name="theta" value="30"/><float name="transmittance" value="0.5"/>
<boolean name="polarize_light" value="true"/>)"),
        0.25f);
    expectGray(sheet("circular", R"(<boolean name="left_handed" value="true"/>)"), 0.5f);
    expectGray(sheet("retarder", R"(<spectrum name="theta" value="30"/><spectrum name="delta" value="90"/>)"),
               1);
    EXPECT_THAT(load(quad("<bsdf type=\"polarizer\"/>")).warnings, ElementsAre(HasSubstr("not polarized")));
    EXPECT_THAT(error(quad(R"(<bsdf type="polarizer"><float name="angle" value="1"/></bsdf>)")),
                HasSubstr("\"angle\""));
}

TEST(FoundScenes, GridTexturesHaveLines) {
    const auto grid = [](const std::string& more) {
        return quad(diffuse("<texture name=\"reflectance\" type=\"gridtexture\">" + more + "</texture>"));
    };
    // Twenty by fifteen squares in view, as many as 2 tan(10 degrees) of uv are wide.
    // 0.1 on both sides of each border: 0.64 of the area has the ground.
    expectGray(picture(grid(R"(<spectrum name="color0" value="0.2"/><spectrum name="color1" value="0.8"/>
<float name="lineWidth" value="0.1"/><float name="uscale" value="56.713"/><float name="vscale" value="56.713"/>)"),
                       "0.6.0"),
               0.64f * 0.2f + 0.36f * 0.8f);
    EXPECT_THAT(error(grid("")), HasSubstr("gridtexture"));
}

TEST(FoundScenes, LayersOf06HaveTexturedRoughness) {
    const auto plastic = [](const std::string& type, const std::string& alpha, const std::string& nested) {
        return quad(fmt::format("<bsdf type=\"{}\">{}{}</bsdf>", type, alpha, nested));
    };
    const std::string number = R"(<float name="alpha" value="0.3"/>)",
                      texture =
                          R"(<texture name="alpha" type="checkerboard"><spectrum name="color0" value="0.3"/>
<spectrum name="color1" value="0.3"/></texture>)";
    for (const auto& [type, nested] : {std::pair("roughplastic", std::string()), {"roughcoating", kHalf}}) {
        const Rgb expected = picture(plastic(type, number, nested), "0.6.0"),
                  found = picture(plastic(type, texture, nested), "0.6.0");
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], expected[k], 0.01f * expected[k]) << type;
        EXPECT_THAT(
            error(plastic(type, texture, nested), type == std::string("roughplastic") ? "3.0.0" : "2.0.0"),
            HasSubstr("alpha"));
    }
}

TEST(FoundScenes, WhatMovesStandsStill) {
    const std::string moves = R"(<transform time="0"><translate x="1"/></transform><transform time="1">
<translate x="9"/></transform></animation>)";
    const auto left = [](const SceneParts& parts) {
        Vec3f lower, upper;
        if (parts.shapes.empty()) return parts.instances.at(0).toWorld.point(Vec3f(0.0f)).x;
        parts.shapes[0]->bounds(lower, upper);
        return (lower.x + upper.x) / 2;
    };
    for (const char* name : {"to_world", "animation"}) {
        const std::string animation = fmt::format("<animation name=\"{}\">", name) + moves;
        const SceneParts shape = load("<shape type=\"sphere\">" + animation + "</shape>");
        EXPECT_THAT(shape.warnings, ElementsAre(HasSubstr("do not move")));
        EXPECT_NEAR(left(shape), 1, 1e-5f);
        EXPECT_NEAR(left(load("<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"/></shape><shape "
                              "type=\"instance\"><ref id=\"g\"/>" +
                              animation + "</shape>")),
                    1, 1e-5f);
    }
    EXPECT_THAT(error("<shape type=\"sphere\"><animation name=\"animation\"/></shape>"),
                HasSubstr("has no <transform>"));
    EXPECT_THAT(error("<shape type=\"sphere\"><transform name=\"to_world\"/><animation name=\"animation\">" +
                      moves + "</shape>"),
                HasSubstr("second time"));
}

TEST(FoundScenes, WhatHasNoEffectIsRead) {
    EXPECT_THAT(load(R"(<shape type="sphere"><float name="silhouette_sampling_weight" value="1"/></shape>
<boolean name="embree_use_robust_intersections" value="true"/>)")
                    .warnings,
                IsEmpty());
    EXPECT_THAT(load(R"(<shape type="sphere"/><sampler type="independent"/>)", "0.6.0").warnings,
                ElementsAre(HasSubstr("part of no <sensor>")));
    EXPECT_THAT(load(R"(<shape type="sphere"/><film type="hdrfilm"/>)").warnings,
                ElementsAre(HasSubstr("part of no <sensor>")));
    EXPECT_THAT(error(R"(<shape type="sphere"/><film type="hdrfilm"/>)", "0.6.0"), HasSubstr("<film"));
    expectGray(
        picture(quad(diffuse(R"(<spectrum name="reflectance" type="uniform"><float name="value" value="0.3"/>
<float name="wavelength_min" value="400"/><float name="wavelength_max" value="700"/></spectrum>)"))),
        0.3f);
    const TemporaryFolder folder;
    const std::string film = R"(<rfilter type="box"/><string name="filename" value="x.jpg"/>)";
    EXPECT_THAT(loadScene(folder.write("scene.xml", underSky(quad(kHalf), "2.0.0", 2, film)), {}).warnings,
                IsEmpty());
    EXPECT_THAT(
        errorOf([&] { loadScene(folder.write("scene.xml", underSky(quad(kHalf), "3.0.0", 2, film)), {}); }),
        HasSubstr("\"filename\""));
}

TEST(FoundScenes, ARadianceMeterSeesOneRay) {
    const TemporaryFolder folder;
    const auto seen = [&](const std::string& parameters, const std::string& size = "1") {
        const auto file = folder.write(
            "scene.xml",
            scene(R"(<integrator type="path"><integer name="max_depth" value="1"/></integrator>
<sensor type="radiancemeter">)" +
                  parameters + R"(<film type="hdrfilm"><integer name="width" value=")" + size + R"("/>
<integer name="height" value="1"/><rfilter type="box"/></film></sensor>
<shape type="sphere"><point name="center" x="5" y="0" z="0"/><float name="radius" value="0.01"/><emitter type="area"><float name="radiance"
value="3"/></emitter></shape><emitter type="constant"><float name="radiance" value="0.25"/></emitter>)"));
        return RenderableScene(file, {}).render("path", 16, 1).at(0);
    };
    const std::string origin = R"(<point name="origin" x="0" y="0" z="0"/>)";
    EXPECT_NEAR(seen(origin + R"(<vector name="direction" x="2" y="0" z="0"/>)"), 3, 1e-3f);
    EXPECT_NEAR(seen(origin + R"(<vector name="direction" x="2" y="0.01" z="0"/>)"), 0.25f, 1e-4f);
    EXPECT_NEAR(
        seen(R"(<transform name="to_world"><lookat origin="5,-3,0" target="5,0,0" up="0,0,1"/></transform>)"),
        3, 1e-3f);
    EXPECT_THAT(errorOf([&] { seen("", "2"); }), HasSubstr("expected a <film> of one"));
    EXPECT_THAT(errorOf([&] { seen(origin); }), HasSubstr("expected both"));
    EXPECT_THAT(errorOf([&] { seen(origin + R"(<vector name="direction" x="0" y="0" z="0"/>)"); }),
                HasSubstr("no length"));
}

TEST(FoundScenes, LookAtOf03HasNineNumbers) {
    const TemporaryFolder folder;
    const auto file =
        folder.write("scene.xml", scene(R"(<camera type="perspective"><float name="fov" value="20"/>
<transform name="toWorld"><lookAt ox="0" oy="0" oz="2" tx="0" ty="0" tz="0" ux="0" uy="1" uz="0"/></transform>
<film type="exrfilm"><integer name="width" value="16"/><integer name="height" value="12"/></film></camera>
<luminaire type="constant"/>)" + quad(kHalf),
                                        "0.3.0"));
    expectGray(meanOf(render(file)), 0.5f);
    EXPECT_THAT(
        errorOf([&] {
            loadScene(folder.write("scene.xml", scene(R"(<camera type="perspective"><transform name="toWorld">
<lookAt ox="0"/></transform></camera>)",
                                                      "0.3.0")),
                      {});
        }),
        HasSubstr("\"oy\""));
}

}  // namespace
}  // namespace metrolux::core::test
