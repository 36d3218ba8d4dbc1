/// What the loader makes of whole scenes: integrators, sensors, lights, options, lenience.

#include "io/scene_loader.h"
#include "support.h"

#include <gmock/gmock.h>

namespace metrolux::core {
namespace {

using test::errorOf;
using test::TemporaryFolder;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kSensor =
    R"(<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="40"/>
    <integer name="height" value="20"/></film></sensor>)";
const std::string kLight = "<emitter type=\"point\"/>";

SceneParts load(const std::string& body, const LoadOptions& options = {},
                const std::string& version = "3.0.0") {
    const TemporaryFolder folder;
    return loadScene(folder.write("scene.xml", test::scene(body, version)), options);
}
SceneParts loadIntegrator(const std::string& integrator, const std::string& version = "3.0.0") {
    return load(integrator + kSensor + kLight, {}, version);
}

TEST(Loader, DefaultIntegratorIsPathsOfAnyLength) {
    const SceneParts parts = loadIntegrator("");
    EXPECT_EQ(parts.integrator, "path");
    EXPECT_EQ(parts.limits.maxDepth, -1);
    EXPECT_EQ(parts.limits.rouletteDepth, 5);
    EXPECT_FALSE(parts.limits.hideEmitters);
    EXPECT_THAT(parts.warnings, IsEmpty());
}

TEST(Loader, IntegratorsSetTheLimits) {
    const std::string depth = R"(<integer name="max_depth" value="7"/><integer name="rr_depth" value="3"/>
        <boolean name="hide_emitters" value="true"/></integrator>)";
    for (const char* type :
         {"path", "ptracer", "light", "bdpt", "vcm", "mcmc_vcm", "volpath", "volpathmis", "sppm"}) {
        const SceneParts parts = loadIntegrator(fmt::format("<integrator type=\"{}\">", type) + depth);
        EXPECT_EQ(parts.integrator, std::string(type).starts_with("volpath") ? "path" : type);
        EXPECT_EQ(parts.limits.maxDepth, 7);
        EXPECT_EQ(parts.limits.rouletteDepth, 3);
        EXPECT_TRUE(parts.limits.hideEmitters);
    }
    EXPECT_EQ(loadIntegrator("<integrator type=\"direct\"/>").limits.maxDepth, 2);
}

TEST(Loader, WrappersUseTheNestedIntegrator) {
    const SceneParts moment =
        loadIntegrator(R"(<integrator type="moment"><integrator type="direct"/></integrator>)");
    EXPECT_EQ(moment.integrator, "direct");
    EXPECT_THAT(moment.warnings, IsEmpty());
    const SceneParts aov = loadIntegrator(R"(<integrator type="aov"><string name="aovs" value="dd:depth"/>
        <integrator name="image" type="path"><integer name="max_depth" value="4"/></integrator></integrator>)");
    EXPECT_EQ(aov.limits.maxDepth, 4);
    EXPECT_THAT(aov.warnings, Contains(AllOf(HasSubstr("scene.xml:2"), HasSubstr("aovs"))));
}

TEST(Loader, LeftoversOfOldIntegratorsAreWarnings) {
    const std::string integrator = R"(<integrator type="path"><integer name="maxDepth" value="9"/>
        <integer name="photonCount" value="5"/><boolean name="strictNormals" value="true"/></integrator>)";
    const SceneParts parts = loadIntegrator(integrator, "0.5.0");
    EXPECT_EQ(parts.limits.maxDepth, 9);
    EXPECT_THAT(parts.warnings, Contains(AllOf(HasSubstr("photon_count"), HasSubstr("strict_normals"))));
    const std::string misspelled =
        "<integrator type=\"path\"><integer name=\"maxDept\" value=\"9\"/></integrator>";
    EXPECT_THAT(loadIntegrator(misspelled, "0.5.0").warnings,
                Contains(HasSubstr("did you mean \"max_depth\"?")));
}

TEST(Loader, OptionsChangeTheFilmAndTheDefaults) {
    const SceneParts plain = load(kSensor + kLight);
    EXPECT_EQ(plain.camera->window().fullWidth, 40);
    LoadOptions options;
    options.width = 16;
    options.height = 12;
    options.hasCrop = true;
    options.cropX = 2, options.cropY = 3, options.cropWidth = 5, options.cropHeight = 6;
    options.defines = {{"depth", "3"}};
    const SceneParts parts = load(R"(<default name="depth" value="9"/><integrator type="path">
        <integer name="max_depth" value="$depth"/></integrator>)" +
                                      kSensor + kLight,
                                  options);
    const FilmWindow& w = parts.camera->window();
    EXPECT_EQ(w.fullWidth, 16);
    EXPECT_EQ(w.fullHeight, 12);
    EXPECT_EQ(w.x, 2);
    EXPECT_EQ(w.height, 6);
    EXPECT_EQ(parts.limits.maxDepth, 3);
    options.cropX = 100;
    EXPECT_THAT(errorOf([&] { load(R"(<default name="depth" value="9"/>)" + kSensor + kLight, options); }),
                HasSubstr("crop"));
}

TEST(Loader, SeveralSensorsUseTheFirst) {
    const SceneParts parts = load(kSensor + "<sensor type=\"perspective\"/>" + kLight);
    EXPECT_EQ(parts.camera->window().fullWidth, 40);
    EXPECT_THAT(parts.warnings, Contains(HasSubstr("2 sensors")));
}

TEST(Loader, SharedAreaEmittersLightEveryShape) {
    const std::string emitter =
        R"(<emitter type="area" id="e"><rgb name="radiance" value="1 2 3"/></emitter>)";
    const SceneParts parts = load(kSensor + emitter + R"(<bsdf type="diffuse" id="b"/>
        <shape type="sphere"><ref id="e"/><ref id="b"/></shape><shape type="rectangle"><ref id="e"/><ref id="b"/></shape>)");
    EXPECT_EQ(parts.lights.size(), 2u);
    ASSERT_EQ(parts.shapes.size(), 2u);
    EXPECT_TRUE(parts.shapes[0]->emitter);
    EXPECT_EQ(parts.shapes[0]->bsdf, parts.shapes[1]->bsdf);  // built once
    EXPECT_THAT(load(kSensor + emitter).warnings, Contains(HasSubstr("no shape refers to")));
}

TEST(Loader, DarkScenesAreWarnings) {
    EXPECT_THAT(load(kSensor).warnings, Contains(HasSubstr("no emitter")));
}

TEST(Loader, UnusedMaterialsAreCheckedAllTheSame) {
    EXPECT_THAT(errorOf([] {
                    load(kSensor + kLight +
                         R"(<bsdf type="diffuse" id="unused"><float name="rough" value="1"/></bsdf>)");
                }),
                HasSubstr("rough"));
    EXPECT_THAT(
        errorOf([] {
            load(kSensor + kLight +
                 R"(<texture type="bitmap" id="t"><string name="filename" value="a.png"/></texture>)");
        }),
        HasSubstr("a.png"));
}

TEST(Loader, LenienceTurnsUnknownNamesIntoWarnings) {
    LoadOptions options;
    options.lenient = true;
    const SceneParts parts = load(kSensor + kLight + R"(<integrator type="magic"/><bsdf type="velvet" id="v"/>
        <emitter type="aurora"/><film type="hdrfilm"/><float name="gain" value="1"/>
        <shape type="sphere"><ref id="v"/><float name="radios" value="3"/></shape>)",
                                  options);
    for (const char* name : {"magic", "velvet", "aurora", "film", "gain", "radios"})
        EXPECT_THAT(parts.warnings, Contains(AllOf(HasSubstr("scene.xml:"), HasSubstr(name)))) << name;
    EXPECT_EQ(parts.shapes.size(), 1u);
    EXPECT_EQ(parts.integrator, "path");
}

TEST(Loader, OldSceneEqualsItsTwin) {
    const SceneParts old =
        load(kSensor + kLight + R"(<integrator type="path"><integer name="maxDepth" value="4"/></integrator>
        <shape type="sphere"><transform name="toWorld"><scale value="2"/></transform>
        <bsdf type="roughplastic"><float name="intIOR" value="1.7"/></bsdf></shape>)",
             {}, "0.6.0");
    const SceneParts twin =
        load(kSensor + kLight + R"(<integrator type="path"><integer name="max_depth" value="4"/></integrator>
        <shape type="sphere"><transform name="to_world"><scale value="2"/></transform>
        <bsdf type="roughplastic"><float name="int_ior" value="1.7"/></bsdf></shape>)");
    EXPECT_EQ(old.limits.maxDepth, twin.limits.maxDepth);
    ASSERT_EQ(old.shapes.size(), 1u);
    EXPECT_FLOAT_EQ(old.shapes[0]->area(), twin.shapes[0]->area());
    EXPECT_THAT(old.warnings, IsEmpty());
}

}  // namespace
}  // namespace metrolux::core
