/// What is an error, a warning or neither: by the version of the file, and by --strict and --lenient.

#include "cases_support.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

SceneParts load(const std::string& text, const LoadOptions& options = {}) {
    const TemporaryFolder folder;
    return loadScene(folder.write("scene.xml", text), options);
}
std::string error(const std::string& text, const LoadOptions& options = {}) {
    return errorOf([&] { load(text, options); });
}
LoadOptions strict() {
    LoadOptions options;
    options.strict = true;
    return options;
}
LoadOptions lenient() {
    LoadOptions options;
    options.lenient = true;
    return options;
}

const std::string kUnused = diffuse(R"(<rgb name="reflectance" value="0.5"/><float name="glow" value="3"/>)");
const std::string kTwice =
    diffuse(R"(<rgb name="reflectance" value="0.1"/><rgb name="reflectance" value="0.5"/>)");

TEST(VersionRules, UnusedPropertiesWarnIn06Only) {
    EXPECT_THAT(load(underSky(quad(kUnused), "0.6.0")).warnings,
                ElementsAre(AllOf(HasSubstr("scene.xml:"), HasSubstr("\"glow\""), HasSubstr("not used"))));
    for (const char* version : {"2.1.0", "3.0.0"}) {
        EXPECT_THAT(error(underSky(quad(kUnused), version)), HasSubstr("\"glow\""));
        EXPECT_THAT(load(underSky(quad(kUnused), version), lenient()).warnings,
                    Contains(HasSubstr("\"glow\"")));
    }
}

TEST(VersionRules, TheLastOfRepeatedPropertiesHoldsIn06) {
    const TemporaryFolder folder;
    const auto file = folder.write("scene.xml", underSky(quad(kTwice), "0.6.0"));
    EXPECT_THAT(loadScene(file, {}).warnings,
                ElementsAre(AllOf(HasSubstr("reflectance"), HasSubstr("last one"))));
    expectGray(meanOf(render(file)), 0.5f);
    for (const char* version : {"2.1.0", "3.0.0"})
        EXPECT_THAT(error(underSky(quad(kTwice), version)), HasSubstr("second time"));
}

TEST(VersionRules, NamesOfChildrenMayRepeatIn06WhereTheyAreCollected) {
    const std::string two = R"(<shape name="s" type="sphere"/><shape name="s" type="cube"/>)";
    EXPECT_EQ(load(underSky(two, "0.6.0")).shapes.size(), 2u);
    EXPECT_THAT(error(underSky(two)), HasSubstr("second time"));
}

TEST(VersionRules, UnknownPluginsAndChildrenAreErrorsInEveryVersion) {
    for (const char* version : {"0.6.0", "2.1.0", "3.0.0"}) {
        EXPECT_THAT(error(underSky(quad("<bsdf type=\"velvet\"/>"), version)), HasSubstr("unknown BSDF"))
            << version;
        EXPECT_THAT(error(underSky(quad(diffuse("<emitter type=\"area\"/>")), version)),
                    HasSubstr("not expected"));
    }
}

TEST(VersionRules, StrictMakesWarningsErrorsInEveryVersion) {
    EXPECT_THAT(error(underSky(quad(kUnused), "0.6.0"), strict()), HasSubstr("\"glow\""));
    EXPECT_THAT(error(underSky(quad(kTwice), "0.6.0"), strict()), HasSubstr("reflectance"));
    for (const char* version : {"0.6.0", "2.1.0", "3.0.0"}) {
        EXPECT_THAT(load(underSky(quad(kHalf), version), strict()).warnings, IsEmpty());
        const std::string bright = diffuse(R"(<rgb name="reflectance" value="2"/>)");
        EXPECT_THAT(error(underSky(quad(bright), version), strict()), HasSubstr("limited to [0, 1]"));
    }
}

TEST(VersionRules, LenientPutsAStandInForEveryUnknownPlugin) {
    const std::string body =
        R"(<sensor type="fisheye_of_mine"><film type="specfilm"><rfilter type="sinc"/></film>
        <sampler type="mine"/></sensor><integrator type="mine"/>
        <shape type="rectangle"><bsdf type="velvet"/><emitter type="glow"/></shape><shape type="teapot"/>
        <shape type="cube"><bsdf type="diffuse"><texture name="reflectance" type="marble"/></bsdf></shape>
        <shape type="cube"><bsdf type="diffuse"><spectrum name="reflectance" type="neon"/></bsdf></shape>
        <shape type="cube"><medium type="ether" name="interior"/></shape>
        <emitter type="aurora"/><emitter type="constant"/>)";
    for (const char* version : {"0.6.0", "2.1.0", "3.0.0"}) {
        const SceneParts parts = load(scene(body, version), lenient());
        EXPECT_EQ(parts.shapes.size(), 4u);
        EXPECT_EQ(parts.lights.size(), 1u);
        for (const char* name : {"fisheye_of_mine", "specfilm", "sinc", "velvet", "glow", "teapot", "marble",
                                 "neon", "ether", "aurora"})
            EXPECT_THAT(parts.warnings, Contains(AllOf(HasSubstr("scene.xml:"), HasSubstr(name)))) << name;
    }
}

TEST(VersionRules, WarningsAreSaidOnce) {
    std::string shapes;
    for (int i = 0; i < 100; ++i) shapes += fmt::format("<bsdf type=\"velvet\" id=\"v{}\"/>\n", i);
    const auto warnings = load(underSky(shapes), lenient()).warnings;
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_THAT(warnings[0],
                AllOf(HasSubstr("scene.xml:"), HasSubstr("id=\"v0\""), HasSubstr("and 99 more like it")));
    const auto others = load(underSky("<bsdf type=\"velvet\"/><bsdf type=\"silk\"/>"), lenient()).warnings;
    EXPECT_EQ(others.size(), 2u);
    EXPECT_THAT(others, Contains(Not(HasSubstr("more like it"))));
}

TEST(VersionRules, WhatMitsubaHasAndWeHaveNotIsNamed) {
    EXPECT_THAT(error(underSky(quad("<bsdf type=\"hk\"/>"), "0.6.0")),
                AllOf(HasSubstr("Mitsuba's BSDF \"hk\" is not supported"), HasSubstr("difftrans")));
    EXPECT_THAT(error(underSky("<shape type=\"ellipsoids\"/>")), HasSubstr("Mitsuba's shape \"ellipsoids\""));
    EXPECT_THAT(error(underSky("<emitter type=\"timed_sunsky\"/>")), HasSubstr("nearest: sunsky"));
    EXPECT_THAT(error(scene("<sensor type=\"fluencemeter\"/>")),
                HasSubstr("Mitsuba's sensor \"fluencemeter\""));
    EXPECT_THAT(error(scene("<sensor type=\"perspective\"><film type=\"specfilm\"/></sensor>")),
                HasSubstr("Mitsuba's film \"specfilm\""));
}

TEST(VersionRules, FragmentsAreReadWhereThatIsAsked) {
    const std::string fragment = scene(quad(kHalf) + "<emitter type=\"constant\"/>", "2.1.0");
    EXPECT_THAT(error(fragment), HasSubstr("no <sensor>"));
    LoadOptions options;
    options.fragment = true;
    const SceneParts parts = load(fragment, options);
    EXPECT_FALSE(parts.camera);
    EXPECT_EQ(parts.shapes.size(), 1u);
    EXPECT_THAT(parts.warnings, Contains(HasSubstr("no <sensor>")));
}

TEST(VersionRules, OneOfSeveralSensorsIsChosen) {
    const auto sensor = [](const std::string& id, int width) {
        return fmt::format(R"(<sensor type="perspective" id="{}"><film type="hdrfilm">
            <integer name="width" value="{}"/></film></sensor>)",
                           id, width);
    };
    const std::string text = scene(sensor("front", 10) + sensor("side", 20) + "<emitter type=\"constant\"/>");
    const auto width = [&](const std::string& choice) {
        LoadOptions options;
        options.sensor = choice;
        return load(text, options).camera->window().fullWidth;
    };
    EXPECT_EQ(width(""), 10);
    EXPECT_EQ(width("0"), 10);
    EXPECT_EQ(width("1"), 20);
    EXPECT_EQ(width("side"), 20);
    EXPECT_THAT(errorOf([&] { width("back"); }),
                AllOf(HasSubstr("--sensor back"), HasSubstr("1 (\"side\")")));
    EXPECT_THAT(errorOf([&] { width("2"); }), HasSubstr("--sensor 2"));
}

TEST(VersionRules, UndefinedParametersAreNamedWithTheDefaultsThereAre) {
    const std::string text = scene(R"(<default name="resolution_x" value="10"/><bsdf type="$kind"/>)");
    EXPECT_THAT(error(text), AllOf(HasSubstr("$kind"), HasSubstr("resolution_x")));
}

TEST(VersionRules, AnAnimationStandsStillWithAWarning) {
    const TemporaryFolder folder;
    const auto load = [&](const std::string& transforms) {
        LoadOptions options;
        options.fragment = true;
        return loadScene(
            folder.write("scene.xml", scene(R"(<shape type="sphere"><animation name="to_world">)" +
                                            transforms + "</animation></shape>")),
            options);
    };
    const SceneParts parts = load(R"(<transform time="0"><translate x="3"/></transform>
<transform time="1"><translate x="9"/></transform>)");
    Vec3f lower, upper;
    parts.shapes.at(0)->bounds(lower, upper);
    EXPECT_NEAR(lower.x, 2, 1e-5);
    EXPECT_THAT(parts.warnings, testing::Contains(testing::HasSubstr("scenes do not move")));
    EXPECT_THAT(load(R"(<transform time="0"><translate x="3"/></transform>)").warnings,
                testing::Each(testing::Not(testing::HasSubstr("scenes do not move"))));
    EXPECT_THAT(errorOf([&] { load(""); }), testing::HasSubstr("has no <transform>"));
}

}  // namespace
}  // namespace metrolux::core::test
