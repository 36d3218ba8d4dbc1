/// Scene files to elements: substitution, includes, references, transforms.

#include "io/mitsuba/parser.h"

#include "support.h"

#include <gmock/gmock.h>

namespace metrolux::core {
namespace {

using mitsuba::ParsedScene;
using mitsuba::parseScene;
using test::errorOf;
using test::parseText;
using test::scene;
using test::TemporaryFolder;
using testing::AllOf;
using testing::HasSubstr;

Transform transformOf(const std::string& operations, const std::string& version = "3.0.0") {
    const ParsedScene parsed = parseText(scene(
        "<shape type=\"cube\"><transform name=\"to_world\">" + operations + "</transform></shape>", version));
    return parsed.root->childrenOf("shape").at(0)->transform("to_world");
}

void expectNear(const Vec3f& a, const Vec3f& b) { EXPECT_LT((a - b).length(), 1e-5f) << a << " and " << b; }

TEST(Parser, DefaultsAndDefinitions) {
    const std::string text = scene(R"(<default name="spp" value="16"/><default name="kind" value="path"/>
        <default name="spp" value="99"/><default name="twice" value="$spp$spp"/>
        <integrator type="$kind"><integer name="a" value="$spp"/><integer name="b" value="$twice"/>
        <string name="c" value="${kind}_$kindly and \$5"/></integrator>)");
    const auto plain = parseText(text).root->childrenOf("integrator").at(0);
    EXPECT_EQ(plain->type, "path");
    EXPECT_EQ(plain->integer("a", 0), 16);
    EXPECT_EQ(plain->integer("b", 0), 1616);
    EXPECT_EQ(plain->string("c", ""), "path_pathly and $5");
    const auto changed =
        parseText(text, {{"spp", "4"}, {"kind", "direct"}}).root->childrenOf("integrator").at(0);
    EXPECT_EQ(changed->type, "direct");
    EXPECT_EQ(changed->integer("b", 0), 44);
}

TEST(Parser, UnknownNamesGetSuggestions) {
    const std::string text =
        scene("<default name=\"resolution\" value=\"16\"/>\n<bsdf type=\"$resoluton\"/>");
    EXPECT_THAT(errorOf([&] { parseText(text); }),
                AllOf(HasSubstr("scene.xml:3"), HasSubstr("did you mean $resolution?")));
    EXPECT_THAT(errorOf([] {
                    parseText(scene("<default name=\"spp\" value=\"1\"/>"), {{"sp", "2"}});
                }),
                AllOf(HasSubstr("scene.xml"), HasSubstr("-D sp=2"), HasSubstr("did you mean \"spp\"?")));
    EXPECT_NO_THROW(
        parseText(scene("<bsdf type=\"$kind\"/>"), {{"kind", "diffuse"}}));  // used without a default
}

TEST(Parser, RunawayDefaultsStop) {
    std::string body = "<default name=\"a0\" value=\"xxxxxxxxxxxxxxxx\"/>";
    for (int i = 1; i < 40; ++i) {
        const std::string before = "$a" + std::to_string(i - 1);
        body += "<default name=\"a" + std::to_string(i) + "\" value=\"" + before + " " + before + "\"/>\n";
    }
    EXPECT_THAT(errorOf([&] { parseText(scene(body)); }), HasSubstr("longer than"));
}

TEST(Parser, IncludesShareDefaultsAndIds) {
    const TemporaryFolder folder;
    folder.write("parts/materials.xml",
                 scene("<bsdf type=\"diffuse\" id=\"$name\"/><include filename=\"more.xml\"/>"));
    folder.write("parts/more.xml",
                 scene("<default name=\"depth\" value=\"3\"/><include filename=\"top.xml\"/>"));
    folder.write("top.xml", scene("<shape type=\"cube\"><ref id=\"red\"/></shape>"));
    folder.write("one.xml", "<bsdf version=\"3.0.0\" type=\"mirror\"/>");
    const auto file = folder.write("scene.xml", scene(R"(<default name="name" value="red"/>
        <include filename="parts/materials.xml"/><integrator type="path"><integer name="d" value="$depth"/></integrator>
        <shape type="sphere"><include filename="one.xml" name="inner"/></shape>)"));
    const ParsedScene parsed = parseScene(file, {});
    EXPECT_EQ(parsed.root->childrenOf("integrator").at(0)->integer("d", 0), 3);
    const auto shapes = parsed.root->childrenOf("shape");
    ASSERT_EQ(shapes.size(), 2u);
    EXPECT_EQ(shapes[0]->childrenOf("bsdf").at(0), parsed.root->childrenOf("bsdf").at(0));
    EXPECT_EQ(shapes[1]->child("inner")->type, "mirror");
    EXPECT_EQ(shapes[0]->location.file, (folder.path() / "top.xml").string());
    EXPECT_EQ(parsed.referenced.size(), 1u);
    EXPECT_EQ(parsed.files.size(), 5u);
}

TEST(Parser, PathsAreSearchedBeforeTheSceneFolder) {
    const TemporaryFolder folder;
    folder.write("data/a.spd", "400 1\n500 1\n");
    folder.write("a.spd", "400 2\n500 2\n");
    folder.write("b.spd", "400 3\n500 3\n");
    const std::string body = R"(<path value="data"/><bsdf type="x"><spectrum name="a" filename="a.spd"/>
        <spectrum name="b" filename="b.spd"/></bsdf>)";
    const ParsedScene parsed = parseScene(folder.write("scene.xml", scene(body)), {});
    const auto bsdf = parsed.root->childrenOf("bsdf").at(0);
    EXPECT_EQ(std::get<mitsuba::SpectrumValue>(bsdf->find("a")->value).values.at(0), 1.0f);
    EXPECT_EQ(std::get<mitsuba::SpectrumValue>(bsdf->find("b")->value).values.at(0), 3.0f);
    ASSERT_EQ(parsed.searchPaths.size(), 2u);
    EXPECT_EQ(parsed.searchPaths[0], folder.path() / "data");
    EXPECT_EQ(mitsuba::findFile("data\\a.spd", folder.path() / "scene.xml", parsed.searchPaths),
              folder.path() / "data/a.spd");
    EXPECT_THAT(errorOf([&] { mitsuba::findFile("c.spd", folder.path() / "scene.xml", parsed.searchPaths); }),
                AllOf(HasSubstr("c.spd"), HasSubstr((folder.path() / "data").string())));
    EXPECT_THAT(errorOf([&] { mitsuba::findFile("data", folder.path() / "scene.xml", parsed.searchPaths); }),
                HasSubstr("is a folder"));
}

TEST(Parser, ReferencesReachForwardAndThroughAliases) {
    const ParsedScene parsed =
        parseText(scene(R"(<shape type="a"><ref id="late"/><ref name="tex" id="other"/></shape>
        <bsdf type="diffuse" id="late"/> <alias id="t" as="middle"/><alias id="middle" as="other"/>
        <texture type="bitmap" id="t"/>)"));
    const auto shape = parsed.root->childrenOf("shape").at(0);
    EXPECT_EQ(shape->childrenOf("bsdf").at(0)->id, "late");
    EXPECT_EQ(shape->child("tex")->id, "t");
}

TEST(Parser, CyclesAreFoundAtAnyLength) {
    for (const int length : {1, 2, 7}) {
        std::string body;
        for (int i = 0; i < length; ++i)
            body += "<bsdf type=\"twosided\" id=\"b" + std::to_string(i) + "\"><ref id=\"b" +
                    std::to_string((i + 1) % length) + "\"/></bsdf>\n";
        body += "<shape type=\"cube\"><ref id=\"b0\"/></shape>";
        EXPECT_THAT(errorOf([&] { parseText(scene(body)); }), AllOf(HasSubstr("cycle"), HasSubstr("\"b0\"")));
    }
}

TEST(Parser, SharedElementsAreNoCycle) {
    const ParsedScene parsed = parseText(scene(R"(<bsdf type="diffuse" id="a"/><bsdf type="blendbsdf" id="b">
        <ref id="a"/><ref id="a"/></bsdf><bsdf type="blendbsdf" id="c"><ref id="b"/><ref id="a"/></bsdf>)"));
    EXPECT_EQ(parsed.root->childrenOf("bsdf").at(2)->childrenOf("bsdf").at(1)->id, "a");
}

TEST(Parser, TransformsApplyInOrder) {
    expectNear(transformOf("<translate x=\"1\"/><rotate z=\"1\" angle=\"90\"/>").point({0, 0, 0}), {0, 1, 0});
    expectNear(transformOf("<rotate z=\"1\" angle=\"90\"/><translate x=\"1\"/>").point({1, 0, 0}), {1, 1, 0});
    expectNear(transformOf("<scale y=\"2\"/>").point({1, 1, 1}), {1, 2, 1});
    expectNear(transformOf("<scale value=\"2\"/>").point({1, 1, 1}), {2, 2, 2});
    expectNear(transformOf("<translate value=\"1 2 3\"/>").point({0, 0, 0}), {1, 2, 3});
    expectNear(transformOf("<matrix value=\"0 1 0 1 0 0 0 0 1\"/>").point({1, 2, 3}), {2, 1, 3});
    expectNear(transformOf("<matrix value=\"1 0 0 5, 0 1 0 6, 0 0 1 7, 0 0 0 1\"/>").point({0, 0, 0}),
               {5, 6, 7});
    const Transform camera = transformOf("<lookat origin=\"1,2,3\" target=\"1 2 5\" up=\"0,1,0\"/>");
    expectNear(camera.point({0, 0, 0}), {1, 2, 3});
    expectNear(camera.vector({0, 0, 1}), {0, 0, 1});
    EXPECT_NO_THROW(transformOf("<lookat origin=\"0 0 0\" target=\"0 1 0\"/>"));  // any up
    EXPECT_NO_THROW(transformOf("<lookAt origin=\"0 0 0\" target=\"0 1 0\" up=\"1 0 0\"/>", "0.4.0"));
}

TEST(Parser, SpectrumPluginsBecomeValues) {
    const ParsedScene parsed = parseText(scene(R"(<bsdf type="x">
        <spectrum type="uniform" name="u"><float name="value" value="0.3"/></spectrum>
        <spectrum type="regular" name="r"><float name="wavelength_min" value="400"/>
            <float name="wavelength_max" value="600"/><string name="values" value="1, 2, 3"/></spectrum>
        <spectrum type="irregular" name="i"><string name="wavelengths" value="400 550"/>
            <string name="values" value="1 2"/></spectrum>
        <spectrum type="blackbody" name="b"><float name="temperature" value="3200"/></spectrum>
        <spectrum type="d65" name="d"><float name="scale" value="2"/></spectrum></bsdf>)"));
    const auto bsdf = parsed.root->childrenOf("bsdf").at(0);
    const auto spectrum = [&](const char* name) {
        return std::get<mitsuba::SpectrumValue>(bsdf->find(name)->value);
    };
    EXPECT_THAT(spectrum("u").values, testing::ElementsAre(0.3f));
    EXPECT_THAT(spectrum("r").wavelengths, testing::ElementsAre(400, 500, 600));
    EXPECT_THAT(spectrum("i").wavelengths, testing::ElementsAre(400, 550));
    EXPECT_FLOAT_EQ(spectrum("b").blackbodyKelvin, 3200);
    EXPECT_EQ(std::get<mitsuba::RgbValue>(bsdf->find("d")->value).value, Rgb(2.0f));
}

TEST(Parser, VersionsAreChecked) {
    for (const char* version : {"2.0.0", "2.1.0", "3.0.0", "3", "3.5.2"})
        EXPECT_FALSE(
            parseText(scene("<bsdf type=\"x\"/>", version)).root->childrenOf("bsdf").at(0)->isLegacy())
            << version;
    for (const char* version : {"0.4.0", "0.5.0", "0.6.0", "0.6"})
        EXPECT_TRUE(
            parseText(scene("<bsdf type=\"x\"/>", version)).root->childrenOf("bsdf").at(0)->isLegacy())
            << version;
    for (const char* version : {"9.0", "", "three", "3.x", "-1.0", "3."})
        EXPECT_THAT(errorOf([&] { parseText(scene("", version)); }), HasSubstr("scene.xml:1: <scene>"))
            << version;
    const TemporaryFolder folder;
    const auto lenient = parseScene(folder.write("scene.xml", "<scene/>"), {}, true);
    EXPECT_EQ(lenient.warnings.size(), 1u);
}

TEST(Parser, LocationsAreLines) {
    const ParsedScene parsed = parseText(
        "<?xml version=\"1.0\"?>\n\n<!-- text\n -->\n<scene version=\"3.0.0\">\r\n\n"
        "  <bsdf type=\"diffuse\"/>\n</scene>");
    EXPECT_EQ(parsed.root->location.line, 5);
    EXPECT_EQ(parsed.root->childrenOf("bsdf").at(0)->location.line, 7);
}

TEST(Parser, Latin1IsConverted) {
    const ParsedScene parsed = parseText(
        "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>"
        "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"gr\xfcn\"/></scene>");
    EXPECT_EQ(parsed.root->childrenOf("bsdf").at(0)->id, "gr\xc3\xbcn");
}

}  // namespace
}  // namespace metrolux::core
