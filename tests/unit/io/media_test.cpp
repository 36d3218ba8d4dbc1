/// Media of Mitsuba's scene files: what is made of them, and where they are put.

#include "io/mitsuba/media.h"

#include "api/object_tree.h"
#include "api/scene_tree.h"
#include "io/mitsuba/xml_writer.h"
#include "media_support.h"
#include "support/shared_data.h"

#include <gmock/gmock.h>

#include <numbers>

namespace metrolux::core::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// The medium of a cube that has `content` in a medium of the type.
SceneParts fog(const std::string& type, const std::string& content, const std::string& version = "3.0.0") {
    return partsOf(withMedia("<shape type=\"cube\"><bsdf type=\"null\"/><medium name=\"interior\" type=\"" +
                                 type + "\">" + content + "</medium></shape>",
                             version));
}
MediumPtr medium(const std::string& type, const std::string& content, const std::string& version = "3.0.0") {
    const SceneParts parts = fog(type, content, version);
    EXPECT_EQ(parts.media.size(), 1u);
    return parts.media.at(0);
}
float phaseOf(const std::string& phase, float cosine, const Vec3f& p = Vec3f(0.0f),
              const std::string& version = "3.0.0") {
    const std::string content = version[0] == '0' ? "<spectrum name=\"sigmaS\" value=\"1\"/>" : "";
    return medium("homogeneous", content + phase, version)->phase().evaluate(p, cosine);
}

TEST(Media, Homogeneous) {
    expectMedium(*medium("homogeneous", ""), Rgb(1.0f), Rgb(0.75f));
    expectMedium(
        *medium("homogeneous", R"(<rgb name="sigma_t" value="1, 0.2, 3"/><float name="scale" value="2.5"/>
        <rgb name="albedo" value="0.9, 0.5, 0"/><boolean name="sample_emitters" value="false"/>
        <boolean name="has_spectral_extinction" value="true"/>)"),
        {2.5f, 0.5f, 7.5f}, {0.9f, 0.5f, 0});
    expectMedium(*medium("homogeneous",
                         R"(<spectrum name="sigma_t" value="0.5"/><volume name="albedo" type="constvolume">
                         <rgb name="value" value="0.1, 0.2, 0.3"/></volume>)",
                         "2.1.0"),
                 Rgb(0.5f), {0.1f, 0.2f, 0.3f});
    EXPECT_FALSE(medium("homogeneous", "<float name=\"albedo\" value=\"0\"/>")->scatters());
}

TEST(Media, HeterogeneousConstantsAreThoseOfTheUnitCube) {
    const MediumPtr constant = medium("heterogeneous", R"(<rgb name="sigma_t" value="0.5, 0.4, 0.3"/>
        <float name="scale" value="5"/><float name="albedo" value="0.8"/>)");
    expectMedium(*constant, {2.5f, 2, 1.5f}, Rgb(0.8f), Vec3f(0.5f));
    expectNear(constant->thickness({-10, 0.5f, 0.5f}, {1, 0, 0}, 100), {2.5f, 2, 1.5f});
    const MediumPtr moved =
        medium("heterogeneous", R"(<volume name="sigma_t" type="constvolume"><float name="value" value="3"/>
        <transform name="to_world"><scale value="2"/><translate x="5"/></transform></volume>)");
    expectNear(moved->thickness({-10, 0.5f, 0.5f}, {1, 0, 0}, 100), Rgb(6.0f));
    expectNear(moved->thickness({-10, 0.5f, 0.5f}, {1, 0, 0}, 16), Rgb(3.0f));
}

TEST(Media, GridsAreReadWithTheirOptions) {
    const TemporaryFolder folder;
    folder.write("a.vol", volFile({2, 1, 1}, {1, 3}, 1, {2, 0, 0, 6, 1, 1}));
    folder.write("color.vol", volFile({1, 1, 1}, {0.1f, 0.2f, 0.3f}, 3));
    const auto of = [&](const std::string& options, const std::string& albedo = "") {
        const std::string text = withMedia(
            R"(<shape type="cube"><bsdf type="null"/><medium name="interior" type="heterogeneous">)" +
            albedo + R"(<volume name="sigma_t" type="gridvolume"><string name="filename" value="a.vol"/>)" +
            options + "</volume></medium></shape>");
        return loadScene(folder.write("scene.xml", text), {}).media.at(0);
    };
    const auto at = [](const MediumPtr& m, float x) { return m->extinction({x, 0.5f, 0.5f}).x; };
    EXPECT_NEAR(at(of(""), 0.25f), 1, 1e-5);
    EXPECT_NEAR(at(of(""), 0.5f), 2, 1e-5);
    EXPECT_NEAR(at(of(R"(<string name="filter_type" value="nearest"/>)"), 0.45f), 1, 1e-5);
    EXPECT_NEAR(
        at(of(R"(<boolean name="use_grid_bbox" value="true"/><boolean name="raw" value="true"/>)"), 4), 2,
        1e-5);
    EXPECT_NEAR(at(of(R"(<transform name="to_world"><scale value="10"/></transform>
                         <boolean name="accel" value="false"/>)"),
                   7.5f),
                3, 1e-5);
    EXPECT_NEAR(at(of(R"(<string name="wrap_mode" value="mirror"/>)"), 0.9f), 3, 1e-5);
    const MediumPtr colored =
        of("",
           R"(<volume name="albedo" type="gridvolume"><string name="filename" value="color.vol"/></volume>)");
    expectMedium(*colored, Rgb(2.0f), {0.1f, 0.2f, 0.3f}, {0.5f, 0.5f, 0.5f});
    // A homogeneous medium may have an albedo that varies.
    const std::string text = withMedia(R"(<shape type="cube"><bsdf type="null"/>
        <medium name="interior" type="homogeneous"><float name="sigma_t" value="2"/>
        <volume name="albedo" type="gridvolume"><string name="filename" value="color.vol"/></volume>
        </medium></shape>)");
    const SceneParts parts = loadScene(folder.write("scene.xml", text), {});
    expectMedium(*parts.media.at(0), Rgb(2.0f), {0.1f, 0.2f, 0.3f}, {9, 9, 9});
}

TEST(Media, PhaseFunctions) {
    const float fourPi = 4 * std::numbers::pi_v<float>;
    EXPECT_NEAR(phaseOf("", 0.3f), 1 / fourPi, 1e-6);
    EXPECT_NEAR(phaseOf("<phase type=\"isotropic\"/>", 0.3f), 1 / fourPi, 1e-6);
    EXPECT_NEAR(phaseOf("<phase type=\"rayleigh\"/>", 0.5f), 0.75f * 1.25f / fourPi, 1e-6);
    const auto hg = [&](float g, float c) {
        return (1 - g * g) / std::pow(1 + g * g - 2 * g * c, 1.5f) / fourPi;
    };
    EXPECT_NEAR(phaseOf("<phase type=\"hg\"/>", 0.9f), hg(0.8f, 0.9f), 1e-5);  // Mitsuba's default
    EXPECT_NEAR(phaseOf("<phase type=\"hg\"><float name=\"g\" value=\"-0.3\"/></phase>", 0.9f),
                hg(-0.3f, 0.9f), 1e-5);
    // A line from 0 backward to its greatest value forward.
    EXPECT_NEAR(phaseOf(R"(<phase type="tabphase"><string name="values" value="0, 1, 2"/></phase>)", 0.5f),
                1.5f / fourPi, 1e-5);
    const std::string parts = R"(<phase name="phase_1" type="hg"><float name="g" value="0.5"/></phase>
        <phase name="phase_0" type="isotropic"/>)";
    EXPECT_NEAR(
        phaseOf("<phase type=\"blendphase\"><float name=\"weight\" value=\"0.25\"/>" + parts + "</phase>", 1),
        0.75f / fourPi + 0.25f * hg(0.5f, 1), 1e-5);
}

TEST(Media, SidesAndPlaces) {
    const SceneParts parts = partsOf(R"(<scene version="3.0.0">
<medium type="homogeneous" id="a"/><medium type="homogeneous" id="b"><float name="sigma_t" value="2"/></medium>
<sensor type="perspective"><ref name="medium" id="b"/><film type="hdrfilm"/></sensor>
<emitter type="point"><ref name="medium" id="a"/></emitter><emitter type="constant"/>
<shape type="sphere"><ref name="interior" id="a"/><ref name="exterior" id="b"/><bsdf type="dielectric"/></shape>
<shape type="cube"><ref name="exterior" id="b"/><emitter type="area"/></shape>
<shape type="cube"><bsdf type="diffuse"/></shape>
<shape type="shapegroup" id="g"><shape type="cube"><bsdf type="null"/><ref name="interior" id="a"/></shape></shape>
<shape type="instance"><ref id="g"/></shape></scene>)");
    ASSERT_EQ(parts.media.size(), 2u);
    const auto number = [&](float sigma) {
        return parts.media[0]->extinction(Vec3f(0.0f)).x == sigma ? MediumIndex{1} : MediumIndex{2};
    };
    const MediumIndex a = number(1), b = number(2);
    EXPECT_EQ(parts.camera->medium, b);
    EXPECT_EQ(parts.lights.at(0)->medium, a);
    EXPECT_EQ(parts.lights.at(1)->medium, std::nullopt);
    ASSERT_TRUE(parts.shapes.at(0)->media);
    EXPECT_EQ(parts.shapes[0]->media->interior, a);
    EXPECT_EQ(parts.shapes[0]->media->exterior, b);
    ASSERT_TRUE(parts.shapes.at(1)->media);
    EXPECT_EQ(parts.shapes[1]->media->interior, 0);
    EXPECT_EQ(parts.shapes[1]->media->exterior, b);
    EXPECT_FALSE(parts.shapes.at(2)->media);
    const auto& inGroup = parts.instances.at(0).group->shapes.at(0)->media;
    ASSERT_TRUE(inGroup);
    EXPECT_EQ(inGroup->interior, a);
    EXPECT_THAT(parts.warnings, IsEmpty());
}

TEST(Media, ScenesFarAwayTakeTheirVolumesWithThem) {
    // In world space also where the shapes are in a group, which has an origin of its own.
    const std::string map = R"(<transform name="to_world"><translate x="100000"/></transform>)";
    const std::string medium = R"(<medium name="interior" type="heterogeneous">
        <volume name="sigma_t" type="constvolume"><float name="value" value="7"/>)" +
                               map + "</volume></medium>";
    const std::string cube = R"(<bsdf type="null"/>)" + medium + "</shape>";
    for (const std::string& body :
         {R"(<shape type="cube">)" + map + cube,
          R"(<shape type="shapegroup" id="g"><shape type="cube">)" + cube +
              R"(</shape><shape type="instance"><ref id="g"/>)" + map + "</shape>"}) {
        const SceneParts parts = partsOf(withMedia(body));
        const auto x = static_cast<float>(100000.0 - parts.origin.x);
        ASSERT_NE(parts.origin.x, 0);
        expectNear(parts.media.at(0)->thickness({x - 5, 0.5f, 0.5f}, {1, 0, 0}, 10), Rgb(7.0f));
    }
}

TEST(Media, ViewsKeepTheMediumOfTheCamera) {
    const TemporaryFolder folder;
    SensorSource source;
    const auto file = folder.write("scene.xml", R"(<scene version="3.0.0"><medium type="homogeneous" id="a"/>
<shape type="cube"><bsdf type="null"/><medium name="interior" type="homogeneous"/></shape>
<sensor type="perspective"><ref id="a"/><film type="hdrfilm"/></sensor><emitter type="constant"/></scene>)");
    const SceneParts parts = loadScene(file, {}, nullptr, &source);
    std::vector<std::string> warnings;
    const SceneView view = makeView(source, {}, warnings);
    EXPECT_EQ(parts.media.size(), 2u);
    EXPECT_TRUE(view.camera->medium);
    EXPECT_EQ(view.camera->medium, parts.camera->medium);
    source.media.clear();
    EXPECT_THAT(errorOf([&] { makeView(source, {}, warnings); }), HasSubstr("not one of the scene's"));
}

TEST(Media, OfVersion06) {
    const char* const v = "0.6.0";
    expectMedium(
        *medium("homogeneous", R"(<spectrum name="sigmaS" value="1, 2, 3"/><spectrum name="sigmaA" value="1"/>
        <float name="scale" value="10"/><string name="strategy" value="maximum"/>)",
                v),
        {20, 30, 40}, {0.5f, 2.0f / 3, 0.75f});
    expectMedium(
        *medium("homogeneous", R"(<spectrum name="sigmaT" value="4"/><spectrum name="albedo" value="0.5"/>
        <float name="densityMultiplier" value="2"/>)",
                v),
        Rgb(8.0f), Rgb(0.5f));
    // What is not given is that of skin.
    expectMedium(*medium("homogeneous", R"(<spectrum name="sigmaA" value="1"/>)", v), {1.74f, 1.88f, 2.01f},
                 {0.74f / 1.74f, 0.88f / 1.88f, 1.01f / 2.01f});
    const auto density = [](const std::string& more) {
        return R"(<string name="method" value="simpson"/><volume name="density" type="constvolume">
            <float name="value" value="2"/></volume>)" +
               more;
    };
    const std::string albedo =
        R"(<volume name="albedo" type="constvolume"><spectrum name="value" value="0.9"/></volume>)";
    const MediumPtr smoke =
        medium("heterogeneous", density(albedo) + R"(<float name="scale" value="3"/>)", v);
    expectMedium(*smoke, Rgb(6.0f), Rgb(0.9f), {50, 0, 0});  // no cube bounds it
    EXPECT_THAT(errorOf([&] { medium("heterogeneous", density(""), v); }), HasSubstr("has no \"albedo\""));
}

TEST(Media, Presets) {
    const auto preset = [](const std::string& name) {
        return fog("homogeneous", "<string name=\"material\" value=\"" + name + "\"/>", "0.6.0");
    };
    const Rgb skinA(0.032f, 0.17f, 0.48f), skinS(0.74f, 0.88f, 1.01f);
    const SceneParts skin = preset("skin1");
    expectNear(skin.media.at(0)->scattering(Vec3f(0.0f)), skinS);
    expectNear(skin.media.at(0)->extinction(Vec3f(0.0f)), skinA + skinS);
    EXPECT_THAT(skin.warnings, ElementsAre(HasSubstr("per millimeter")));
    // Its scattering is reduced by its mean cosine, as there.
    const Rgb milk = preset("Lowfat Milk").media.at(0)->scattering(Vec3f(0.0f));
    expectNear(milk, {13.1157f * 0.068f, 15.4445f * 0.098f, 17.9572f * 0.141f});
    EXPECT_THAT(errorOf([&] { preset("Lofat Milk"); }),
                AllOf(HasSubstr("Lofat Milk"), HasSubstr("Espresso")));
    EXPECT_EQ(preset("Budweiser Beder").media.at(0)->extinction(Vec3f(0.0f)),
              preset("budweiser beer").media.at(0)->extinction(Vec3f(0.0f)));
}

TEST(Media, MixturesOf06MayAbsorb) {
    const std::string parts =
        R"(<phase type="isotropic"/><phase type="hg"><float name="g" value="0.5"/></phase>)";
    const auto mixture = [&](const std::string& weights) {
        return medium("homogeneous",
                      R"(<spectrum name="sigmaT" value="1"/><spectrum name="albedo" value="0.8"/>
            <phase type="mixturephase"><string name="weights" value=")" +
                          weights + "\"/>" + parts + "</phase>",
                      "0.6.0");
    };
    expectMedium(*mixture("0.25, 0.75"), Rgb(1.0f), Rgb(0.8f));
    expectMedium(*mixture("0.1, 0.3"), Rgb(1.0f), Rgb(0.8f * 0.4f));
    const float fourPi = 4 * std::numbers::pi_v<float>, hg = 0.75f / std::pow(0.25f, 1.5f);
    EXPECT_NEAR(mixture("0.1, 0.3")->phase().evaluate(Vec3f(0.0f), 1), (0.25f + 0.75f * hg) / fourPi, 1e-4);
    expectMedium(*mixture("1, 3"), Rgb(1.0f), Rgb(0.8f));
}

TEST(Media, ABoundaryWithoutBsdf) {
    const std::string cube = R"(<shape type="cube"><medium name="interior" type="homogeneous">
        <spectrum name="albedo" value="0.5"/><spectrum name=")";
    const SceneParts old = partsOf(withMedia(cube + R"(sigmaT" value="1"/></medium></shape>)", "0.6.0"));
    EXPECT_TRUE(old.shapes.at(0)->bsdf->isTransmissive());
    EXPECT_THAT(old.warnings, IsEmpty());
    const SceneParts today = partsOf(withMedia(cube + R"(sigma_t" value="1"/></medium></shape>)"));
    EXPECT_FALSE(today.shapes.at(0)->bsdf->isTransmissive());
    EXPECT_THAT(today.warnings, ElementsAre(HasSubstr("has no BSDF")));
}

TEST(Media, WhatHasNoEffectIsWarnedOf) {
    const SceneParts unused = partsOf(withMedia(R"(<medium type="homogeneous" id="m"/>)"));
    EXPECT_THAT(unused.warnings, ElementsAre(AllOf(HasSubstr("scene.xml:4"), HasSubstr("no effect"))));
    EXPECT_THAT(unused.media, IsEmpty());
    EXPECT_THAT(fog("heterogeneous", R"(<integer name="majorant_resolution_factor" value="8"/>)").warnings,
                ElementsAre(HasSubstr("\"majorant_resolution_factor\" has no effect")));
}

TEST(Media, NoMoreThanAnIndexCanTell) {
    mitsuba::LoadContext context;
    context.media.resize(65535);
    mitsuba::Element element;
    element.tag = "medium";
    element.type = "homogeneous";
    EXPECT_THAT(errorOf([&] { mitsuba::mediumIndex(element, context); }), HasSubstr("more than 65535 media"));
    context.media.resize(65534);
    EXPECT_EQ(mitsuba::mediumIndex(element, context), 65535);
}

TEST(Media, LenientlyUnknownTypesHaveStandIns) {
    LoadOptions lenient;
    lenient.lenient = true;
    const std::string body =
        R"(<shape type="cube"><bsdf type="null"/><medium name="interior" type="ether"/></shape>
<shape type="cube"><bsdf type="null"/><medium name="interior" type="homogeneous"><phase type="sggx"/></medium></shape>
<shape type="cube"><bsdf type="null"/><medium name="interior" type="heterogeneous">
<volume name="sigma_t" type="hgridvolume"/></medium></shape><shape type="cube"><subsurface type="dipole"/></shape>)";
    const SceneParts parts = partsOf(withMedia(body), lenient);
    EXPECT_EQ(parts.media.size(), 2u);
    EXPECT_EQ(parts.shapes.at(0)->media->interior, 0);
    for (const char* what : {"ether", "sggx", "hgridvolume", "subsurface"})
        EXPECT_THAT(parts.warnings, Contains(HasSubstr(what)));
}

TEST(Media, ConvertedTheyAreTheSame) {
    const TemporaryFolder folder;
    folder.write("a.vol", volFile({2, 1, 1}, {1, 3}));
    const auto file = folder.write("scene.xml", withMedia(R"(<medium type="homogeneous" id="fog">
<rgb name="sigma_t" value="0.1, 0.2, 0.3"/><phase type="hg"><float name="g" value="0.3"/></phase></medium>
<shape type="cube"><bsdf type="null"/><ref name="exterior" id="fog"/><medium name="interior" type="heterogeneous">
<volume name="sigma_t" type="gridvolume"><string name="filename" value="a.vol"/></volume></medium></shape>)"));
    const std::filesystem::path out = folder.path() / "new" / "converted.xml";
    std::filesystem::create_directories(out.parent_path());
    mitsuba::writeScene(parseSceneFile(file, {}), out);
    const SceneParts before = loadScene(file, {}), after = loadScene(out, {});
    ASSERT_EQ(after.media.size(), before.media.size());
    EXPECT_EQ(after.shapes.at(0)->media->interior, before.shapes.at(0)->media->interior);
    EXPECT_EQ(after.shapes.at(0)->media->exterior, before.shapes.at(0)->media->exterior);
    const Vec3f p(0.4f, 0.5f, 0.5f);
    for (size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(after.media[i]->extinction(p), before.media[i]->extinction(p));
        EXPECT_EQ(after.media[i]->phase().evaluate(p, 0.3f), before.media[i]->phase().evaluate(p, 0.3f));
    }
}

TEST(Media, OfObjects) {
    const Object fog("homogeneous",
                     {{"sigma_t", Color{1, 2, 3}}, {"albedo", 0.5}, {"phase", Object("hg", {{"g", 0.5}})}});
    const Object cube("cube", {{"bsdf", Object("null")}, {"interior", Reference{"fog"}}});
    const Object sensor("perspective", {{"film", Object("hdrfilm")}, {"medium", Reference{"fog"}}});
    const Object scene("scene",
                       {{"fog", fog}, {"cube", cube}, {"light", Object("constant")}, {"sensor", sensor}});
    const mitsuba::ParsedScene tree = api::parsedScene(scene, ".");
    SensorSource source;
    const SceneParts parts = buildScene(tree, {}, nullptr, &source);
    ASSERT_EQ(parts.media.size(), 1u);
    expectMedium(*parts.media[0], {1, 2, 3}, Rgb(0.5f));
    EXPECT_EQ(parts.shapes.at(0)->media.value().interior, 1);
    EXPECT_EQ(parts.camera->medium, MediumIndex{1});

    const auto changed = [&](const std::string& path, const Value& value, bool isView) {
        api::SceneTree changes(tree, source.element, source.element);
        changes.set(path, value);
        mitsuba::ParsedScene result = changes.finish();
        EXPECT_EQ(changes.onlySensorChanged(), isView) << path;
        return buildScene(std::move(result), {});
    };
    expectMedium(*changed("fog.sigma_t", Vector{3, 2, 1}, false).media.at(0), {3, 2, 1}, Rgb(0.5f));
    const Object rayleigh("rayleigh");
    EXPECT_NEAR(changed("fog.phase", rayleigh, false).media.at(0)->phase().evaluate(Vec3f(0.0f), 0),
                0.1875f / std::numbers::pi_v<float>, 1e-6);
    // The index of a camera's medium is the whole scene's.
    EXPECT_EQ(changed("sensor.fov", 20.0, false).camera->medium, MediumIndex{1});
}

TEST(Media, ScenesOfMitsubasTests) {
    const auto folder = sharedPath("conformance-media/tests/scenes/participating_media");
    METROLUX_NEEDS_SHARED(folder);
    int scenes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".xml") continue;
        ++scenes;
        const SceneParts parts = loadScene(entry.path(), {});
        const bool hasMedia = entry.path().filename() != "test_surf_area_light_volpath.xml";
        EXPECT_EQ(parts.media.size(), hasMedia ? 1u : 0u) << entry.path();
        EXPECT_THAT(parts.warnings, ElementsAre(HasSubstr("\"far_clip\""))) << entry.path();
    }
    EXPECT_EQ(scenes, 7);
}

}  // namespace
}  // namespace metrolux::core::test
