/// Scenes written as Mitsuba 3's XML: read again they render to the same bits.

#include "gltf_support.h"
#include "io/mitsuba/xml_writer.h"
#include "paths.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<float> picture(const fs::path& file) {
    LoadOptions options;
    options.setResolution(24, 16);
    return RenderableScene(file, options).render("vcm", 2, 1);
}

void expectTheSameAfterConversion(const fs::path& file, const fs::path& folder) {
    SCOPED_TRACE(file.string());
    const fs::path out = folder / "new" / "converted.xml";
    fs::create_directories(out.parent_path());
    mitsuba::writeScene(parseSceneFile(file, {}), out);
    EXPECT_EQ(picture(out), picture(file));
    // And once more, which changes nothing that is read.
    const fs::path again = folder / "new" / "again.xml";
    mitsuba::writeScene(parseSceneFile(out, {}), again);
    EXPECT_EQ(picture(again), picture(file));
}

TEST(Convert, ScenesOfTheRepositoryKeepTheirBits) {
    const TemporaryFolder folder;
    for (const char* name : {"environment", "spot-directional", "textured"})
        expectTheSameAfterConversion(fs::path(METROLUX_SOURCE_DIR) / "scenes" / name / "scene.xml",
                                     folder.path());
}

TEST(Convert, GltfKeepsItsBits) {
    const TemporaryFolder folder;
    GltfMaker maker;
    Json material{{"pbrMetallicRoughness",
                   {{"baseColorTexture", {{"index", maker.texture({2, 1, 3, {1, 0, 0.2f, 0.1f, 0.5f, 1}})}}},
                    {"metallicRoughnessTexture", {{"index", 0}}},
                    {"roughnessFactor", 0.7}}},
                  {"normalTexture", {{"index", 0}}},
                  {"alphaMode", "MASK"}};
    const size_t colors = maker.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}, "VEC3", 3);
    const size_t textured = maker.quad(material), colored = maker.quad(nullptr, {{"COLOR_0", colors}});
    maker.node({{"mesh", textured}, {"rotation", {0.3, 0.1, 0.2, 0.9}}, {"scale", {1, 2, 0.7}}});
    maker.node({{"mesh", colored}, {"translation", {0.3, 0.1, -1}}, {"rotation", {0.1, 0.7, 0, 0.7}}});
    maker.node({{"mesh", colored}, {"translation", {-0.3, 0.4, -1}}, {"rotation", {0.5, 0.1, 0, 0.8}}});
    Json lamp = GltfMaker::lightNode(maker.light({{"type", "spot"}, {"intensity", 30}}));
    lamp.update({{"translation", {0.2, 0.1, 2}}, {"rotation", {0.05, 0.01, 0, 1}}});
    maker.node(lamp);
    expectTheSameAfterConversion(folder.write("scene.glb", maker.glb()), folder.path());
}

TEST(Convert, EveryKindOfValueAndSharedObjects) {
    const TemporaryFolder folder;
    folder.write("lamp.ies", "IESNA91\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 20\n0 180\n0\n40 40\n");
    expectTheSameAfterConversion(
        folder.write("scene.xml", R"(<scene version="2.1.0"><default name="turn" value="30"/>
<integrator type="path"><integer name="max_depth" value="5"/><boolean name="hide_emitters" value="true"/></integrator>
<sensor type="perspective" id="a&amp;b"><float name="fov" value="55.3"/><transform name="to_world">
<translate x="0.1" y="0.2"/><rotate x="0.2" y="1" angle="$turn"/><lookat origin="0.3,2,5" target="0,0.1,0" up="0.1,1,0"/>
</transform><film type="hdrfilm"><rfilter type="tent"/></film></sensor>
<bsdf type="twosided" id="both"><bsdf type="roughconductor"><string name="material" value="Au"/>
<texture name="alpha" type="checkerboard"><float name="color0" value="0.1"/><transform name="to_uv"><scale x="3.3"/>
</transform></texture></bsdf></bsdf>
<shape type="sphere"><point name="center" x="0.1" y="0.33" z="-0.2"/><ref name="bsdf" id="both"/></shape>
<shape type="shapegroup" id="group"><shape type="cube"><ref id="both"/></shape><shape type="disk"><bsdf type="diffuse">
<spectrum name="reflectance" value="400:0.1, 550.5:0.7, 700:0.3"/></bsdf></shape></shape>
<shape type="instance"><ref id="group"/><transform name="to_world"><scale value="0.4"/><rotate z="1" angle="33"/>
<translate x="-1.7" y="0.3"/></transform></shape>
<shape type="instance"><ref id="group"/><transform name="to_world"><matrix value="0.3 0.1 0 1.2 0 0.4 0.1 0 0 0.2 0.5 1 0 0 0 1"/>
</transform></shape>
<shape type="rectangle"><transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/><translate y="-1"/></transform></shape>
<emitter type="goniometric"><string name="filename" value="lamp.ies"/><transform name="to_world">
<lookat origin="1,4,1" target="0,0,0" up="0,1,0"/></transform></emitter>
<emitter type="constant"><blackbody name="radiance" temperature="4321" scale="1e-9"/></emitter></scene>)"),
        folder.path());
}

/// The inverse of a map is the product of the inverses of its steps, not that of its matrix.
TEST(Convert, TransformsKeepTheirSteps) {
    const TemporaryFolder folder;
    const auto file = folder.write("scene.xml", scene(R"(<shape type="cube"><transform name="to_world">
<scale x="0.3" y="1.7" z="0.9"/><rotate x="0.2" y="1" z="0.4" angle="33.3"/><translate x="-1.7" y="0.3" z="12.1"/>
<rotate z="1" angle="12.7"/></transform></shape>)"));
    mitsuba::writeScene(parseSceneFile(file, {}), folder.path() / "new.xml");
    const auto inverse = [](const fs::path& path) {
        const mitsuba::ParsedScene parsed = parseSceneFile(path, {});
        return parsed.root->childrenOf("shape").at(0)->transform("to_world").inverse();
    };
    const Transform a = inverse(file), b = inverse(folder.path() / "new.xml");
    for (int i = 0; i < 16; ++i) EXPECT_EQ(a.at(i / 4, i % 4), b.at(i / 4, i % 4)) << i;
}

TEST(Convert, RefusesScenesOfOldRulesBeforeItWrites) {
    const TemporaryFolder folder;
    const auto scene06 =
        folder.write("old.xml", scene(R"(<shape type="sphere"><bsdf type="coating"/></shape>)", "0.6.0"));
    EXPECT_THAT(errorOf([&] { mitsuba::writeScene(parseSceneFile(scene06, {}), folder.path() / "new.xml"); }),
                HasSubstr("of a scene of 0.x"));
    EXPECT_FALSE(fs::exists(folder.path() / "new.xml"));
}

}  // namespace
}  // namespace metrolux::core::test
