// Shape elements of scenes: properties, materials, lights, groups and instances.
#include "io/scene_loader.h"
#include "support.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kCamera = "<sensor type=\"perspective\"/>";

SceneParts load(const std::string& shapes, bool lenient = false) {
    const TemporaryFolder folder;
    folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 0.25\nf 1/1 2/2 3/3\n");
    folder.write(
        "t.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float u\nproperty float v\nelement face 1\nproperty list uchar int "
        "vertex_index\nend_header\n"
        "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 0.25\n3 0 1 2\n");
    LoadOptions options;
    options.lenient = lenient;
    return loadScene(folder.write("scene.xml", scene(kCamera + shapes)), options);
}

std::string refusal(const std::string& shapes) {
    return errorOf([&] { load(shapes); });
}

const TriangleMesh& mesh(const SceneParts& parts) {
    return dynamic_cast<const TriangleMesh&>(*parts.shapes.at(0));
}

TEST(ShapePlugins, AnalyticShapes) {
    const SceneParts parts = load(
        "<shape type=\"sphere\"><point name=\"center\" value=\"1, 0, 0\"/><float name=\"radius\" "
        "value=\"2\"/></shape>"
        "<shape type=\"cylinder\"><point name=\"p1\" value=\"0, 0, 3\"/><float name=\"radius\" "
        "value=\"2\"/></shape>"
        "<shape type=\"disk\"><transform name=\"to_world\"><scale value=\"2\"/></transform></shape>"
        "<shape type=\"rectangle\" id=\"r\"><boolean name=\"flip_normals\" value=\"true\"/></shape>"
        "<shape type=\"cube\"/>");
    ASSERT_EQ(parts.shapes.size(), 5u);
    const float areas[] = {16 * kPi, 12 * kPi, 4 * kPi, 4, 24};
    for (size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(parts.shapes[i]->area(), areas[i], 1e-4f * areas[i]);
        EXPECT_TRUE(parts.shapes[i]->bsdf);
        EXPECT_FALSE(parts.shapes[i]->emitter);
    }
    EXPECT_LT(parts.shapes[3]->sampleArea({0.5f, 0.5f}).si.ng.z, 0);
    EXPECT_EQ(parts.shapes[3]->id, "r");
    const SurfaceInteraction si = parts.shapes[0]->sampleArea({0.5f, 0.5f}).si;
    EXPECT_NEAR(parts.shapes[0]->bsdf->albedo(si).x, 0.5, 1e-6);
}

TEST(ShapePlugins, MeshesFlipTexCoordsAsMitsuba) {
    EXPECT_EQ(mesh(load("<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/></shape>")).uvs[2].y,
              0.75f);
    EXPECT_EQ(mesh(load("<shape type=\"ply\"><string name=\"filename\" value=\"t.ply\"/></shape>")).uvs[2].y,
              0.25f);
    const SceneParts parts = load(
        "<shape type=\"ply\"><string name=\"filename\" value=\"t.ply\"/><boolean name=\"flip_tex_coords\" "
        "value=\"true\"/>"
        "<boolean name=\"face_normals\" value=\"true\"/><boolean name=\"flip_normals\" "
        "value=\"true\"/></shape>");
    EXPECT_EQ(mesh(parts).uvs[2].y, 0.75f);
    EXPECT_TRUE(mesh(parts).normals.empty());
    EXPECT_TRUE(mesh(parts).flipNormals);
}

TEST(ShapePlugins, EmittersAreAttached) {
    const SceneParts parts = load(
        "<shape type=\"rectangle\"><emitter type=\"area\"><rgb name=\"radiance\" "
        "value=\"2\"/></emitter></shape>"
        "<shape type=\"sphere\"/>");
    ASSERT_EQ(parts.lights.size(), 1u);
    EXPECT_EQ(parts.shapes[0]->emitter.get(), parts.lights[0].get());
    // A light without a BSDF does not reflect.
    EXPECT_EQ(parts.shapes[0]->bsdf->albedo(parts.shapes[0]->sampleArea({0.5f, 0.5f}).si), Rgb(0.0f));
}

TEST(ShapePlugins, MaterialsMayBeShared) {
    const SceneParts parts = load(
        "<bsdf type=\"diffuse\" id=\"m\"/><shape type=\"sphere\"><ref id=\"m\"/></shape>"
        "<shape type=\"cube\"><ref name=\"bsdf\" id=\"m\"/></shape>");
    EXPECT_EQ(parts.shapes[0]->bsdf, parts.shapes[1]->bsdf);
}

TEST(ShapePlugins, GroupsAreBuiltOnceAndPlacedOften) {
    const std::string group =
        "<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"/><shape type=\"cube\"/></shape>";
    const std::string places =
        "<shape type=\"instance\"><ref id=\"g\"/></shape><shape type=\"instance\"><ref id=\"g\"/>"
        "<transform name=\"to_world\"><translate x=\"5\"/></transform></shape>";
    const SceneParts parts = load(group + places);
    EXPECT_TRUE(parts.shapes.empty());
    ASSERT_EQ(parts.instances.size(), 2u);
    EXPECT_EQ(parts.instances[0].group, parts.instances[1].group);
    EXPECT_EQ(parts.instances[0].group->shapes.size(), 2u);
    EXPECT_TRUE(parts.instances[0].group->shapes[0]->bsdf);
    EXPECT_EQ(parts.instances[1].toWorld.point({0, 0, 0}), Vec3f(5, 0, 0));
}

TEST(ShapePlugins, RefusalsSayWhereAndWhy) {
    EXPECT_THAT(refusal("\n\n<shape type=\"spere\"/>"),
                AllOf(HasSubstr("scene.xml:4"), HasSubstr("\"sphere\"")));
    EXPECT_THAT(refusal("<shape type=\"obj\"/>"), HasSubstr("filename"));
    EXPECT_THAT(refusal("<shape type=\"obj\"><string name=\"filename\" value=\"none.obj\"/></shape>"),
                HasSubstr("none.obj"));
    EXPECT_THAT(refusal("<shape type=\"ply\"><string name=\"filename\" value=\"t.obj\"/></shape>"),
                AllOf(HasSubstr("scene.xml:2"), HasSubstr("t.obj"), HasSubstr("not a PLY")));
    EXPECT_THAT(refusal("<shape type=\"serialized\"><string name=\"filename\" value=\"t.ply\"/>"
                        "<integer name=\"shape_index\" value=\"-1\"/></shape>"),
                HasSubstr("shape_index"));
    EXPECT_THAT(refusal("<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/>"
                        "<float name=\"max_smooth_angle\" value=\"30\"/></shape>"),
                HasSubstr("max_smooth_angle"));
    EXPECT_THAT(refusal("<shape type=\"sphere\"><float name=\"radius\" value=\"-1\"/></shape>"),
                HasSubstr("radius"));
    EXPECT_THAT(refusal("<shape type=\"sphere\"><float name=\"radus\" value=\"1\"/></shape>"),
                HasSubstr("radius"));
    EXPECT_THAT(
        refusal("<shape type=\"sphere\"><transform name=\"to_world\"><scale z=\"0\"/></transform></shape>"),
        HasSubstr("scene.xml:2"));
    EXPECT_THAT(refusal("<shape type=\"sphere\"><medium name=\"inside\" type=\"homogeneous\"/></shape>"),
                HasSubstr("interior or exterior"));
    EXPECT_THAT(refusal("<shape type=\"sphere\"><bsdf type=\"diffuse\"/><bsdf type=\"diffuse\"/></shape>"),
                HasSubstr("2 children"));
    EXPECT_THAT(refusal("<shape type=\"sphere\"><emitter type=\"point\"/></shape>"), HasSubstr("area"));
    EXPECT_THAT(refusal("<shape type=\"instance\"/>"), HasSubstr("shapegroup"));
    EXPECT_THAT(refusal("<shape type=\"shapegroup\" id=\"g\"/>"), HasSubstr("without shapes"));
    EXPECT_THAT(refusal("<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"><emitter "
                        "type=\"area\"/></shape></shape>"),
                HasSubstr("cannot be emitters"));
    EXPECT_THAT(
        refusal("<shape type=\"obj\"><string name=\"filename\" value=\"t.obj\"/><transform name=\"to_world\">"
                "<scale value=\"1e-30\"/></transform><emitter type=\"area\"/></shape>"),
        HasSubstr("area"));
}

TEST(ShapePlugins, LenientLeavesUnknownShapesOut) {
    const SceneParts parts = load("<shape type=\"deformable\"/><shape type=\"sphere\"/>", true);
    EXPECT_EQ(parts.shapes.size(), 1u);
    EXPECT_THAT(parts.warnings, testing::Contains(HasSubstr("deformable")));
}

}  // namespace
}  // namespace metrolux::core::test
