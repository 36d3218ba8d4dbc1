/// What other people's meshes and transforms hold and was once refused or read wrong. The value is the
/// reflectance that the image shows.

#include "cases_support.h"
#include "io/mesh_io.h"
#include "io/mesh_smoothing.h"

#include <gmock/gmock.h>

namespace metrolux::core::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kCube =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
/// The same with a normal at each corner of a face.
const std::string kCubeWithNormals =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "vn 0 0 -1\nvn 0 0 1\nvn 0 -1 0\nvn 1 0 0\nvn 0 1 0\nvn -1 0 0\n"
    "f 4//1 3//1 2//1 1//1\nf 5//2 6//2 7//2 8//2\nf 1//3 2//3 6//3 5//3\nf 2//4 3//4 7//4 6//4\n"
    "f 3//5 4//5 8//5 7//5\nf 4//6 1//6 5//6 8//6\n";

class Geometry : public testing::Test {
  protected:
    Rgb color(const std::string& text) { return meanOf(render(folder_.write("scene.xml", text))); }
    SceneParts load(const std::string& text) { return loadScene(folder_.write("scene.xml", text), {}); }
    std::string error(const std::string& text) {
        return errorOf([&] { load(text); });
    }
    TemporaryFolder folder_;
};

std::string transform(const std::string& operations) {
    return "<transform name=\"to_world\">" + operations + "</transform>";
}
std::string shape(const std::string& type, const std::string& more, const std::string& operations) {
    return "<shape type=\"" + type + "\">" + more + transform(operations) + kHalf + "</shape>";
}
std::string file(const std::string& name) { return "<string name=\"filename\" value=\"" + name + "\"/>"; }
const std::string kFlat = R"(<boolean name="face_normals" value="true"/>)";

TEST_F(Geometry, MirroredMeshesKeepTheirOutside) {
    folder_.write("cube.obj", kCube);
    folder_.write("normals.obj", kCubeWithNormals);
    const std::string mirrors[] = {R"(<scale x="-1"/>)", R"(<scale y="-1"/>)", R"(<scale z="-1"/>)",
                                   R"(<scale value="-1"/>)", R"(<matrix value="0 1 0 1 0 0 0 0 1"/>)"};
    for (const char* name : {"cube.obj", "normals.obj"})
        for (const std::string& more : {std::string(), kFlat}) {
            const float plain = color(underSky(shape("obj", file(name) + more, ""), "3.0.0", 6)).x;
            EXPECT_GT(plain, 0.4f);
            EXPECT_LT(plain, 0.6f);
            for (const std::string& mirror : mirrors)
                expectGray(color(underSky(shape("obj", file(name) + more, mirror), "3.0.0", 6)), plain);
        }
}

TEST_F(Geometry, OtherMirroredShapesAreAsInMitsuba) {
    const auto at = [&](const std::string& type, const std::string& version, const std::string& mirror) {
        return color(underSky(shape(type, "", mirror), version, 6));
    };
    const std::string along = R"(<scale x="-1"/>)";
    for (const char* version : {"0.6.0", "2.1.0", "3.0.0"})
        for (const char* type : {"rectangle", "cube", "disk"}) {
            SCOPED_TRACE(type);
            expectColor(at(type, version, along), at(type, version, ""));
        }
    const Rgb sphere = at("sphere", "3.0.0", "");
    EXPECT_GT(sphere.x, 0.4f);
    expectColor(at("sphere", "0.6.0", along), sphere);
    EXPECT_LT(at("sphere", "3.0.0", along).x, 0.5f * sphere.x);  // 2 and 3 turn its normals
    const std::string group = R"(<shape type="shapegroup" id="g">)" + shape("cube", "", "") +
                              R"(</shape><shape type="instance"><ref id="g"/>)" + transform(along) +
                              "</shape>";
    expectColor(color(underSky(group, "3.0.0", 6)), at("cube", "3.0.0", ""));
}

TEST_F(Geometry, OddObjFiles) {
    const std::string vertices = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    const auto of = [&](const std::string& text) {
        folder_.write("a.obj", text);
        return color(underSky(shape("obj", file("a.obj"), ""), "0.6.0"));
    };
    expectGray(of("\xef\xbb\xbf" + vertices + "f 1 2 3 4\n"), 0.5f);
    expectGray(of(vertices + "f 1 2 \\\n3 4\n"), 0.5f);
    expectGray(of(vertices + "f \\\r\n1 \\\r\n2 3 \\ \r\n4"), 0.5f);
    expectGray(of("# C:\\meshes\\\n" + vertices + "f 1 2 3 4 # \\\n"), 0.5f);
    expectGray(of(vertices + "f 1 2\nf 1\nf\nf 1 2 3 4\n"), 0.5f);
    EXPECT_THAT(load(underSky(shape("obj", file("a.obj"), ""))).warnings,
                Contains(HasSubstr("faces of less than three vertices are left out (3)")));
    folder_.write("a.obj", vertices + "f 1 \\\n2 3\nf 1 2 x\n");
    EXPECT_THAT(error(underSky(shape("obj", file("a.obj"), ""))), HasSubstr("a.obj:7: \"x\""));
    folder_.write("a.obj", vertices + "f 1 2\n");
    EXPECT_THAT(error(underSky(shape("obj", file("a.obj"), ""))), HasSubstr("no faces"));
}

TEST_F(Geometry, PlyFacesOfTwoVerticesAreSkipped) {
    folder_.write("a.ply",
                  "\xef\xbb\xbfply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                  "property float z\nelement face 3\nproperty list uchar int vertex_indices\n"
                  "property float tone\nend_header\n"
                  "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n3 0 1 2 1\n2 0 1 2\n3 0 2 3 3\n");
    const std::string scene = underSky(shape("ply", file("a.ply"), ""));
    expectGray(color(scene), 0.5f);
    EXPECT_THAT(load(scene).warnings,
                Contains(HasSubstr("faces of less than three vertices are left out (1)")));
}

TEST_F(Geometry, NoAxisIsNeededToRotateByNothing) {
    expectGray(color(underSky(quad(kHalf, transform(R"(<rotate x="0" y="0" z="0" angle="0"/>)")))), 0.5f);
    expectGray(color(underSky(quad(kHalf, transform(R"(<rotate angle="0"/>)")))), 0.5f);
    EXPECT_THAT(error(underSky(quad(kHalf, transform(R"(<rotate angle="1"/>)")))), HasSubstr("axis"));
}

TEST_F(Geometry, FlattenedObjectsAreObjects) {
    folder_.write("q.obj", kQuadFile);
    folder_.write("cube.obj", kCube);
    const std::string flat = R"(<scale x="1" y="1" z="0"/>)";
    for (const char* type : {"rectangle", "disk"}) expectGray(color(underSky(shape(type, "", flat))), 0.5f);
    for (const std::string& more : {std::string(), kFlat})
        expectGray(color(underSky(shape("obj", file("q.obj") + more, flat))), 0.5f);
    // Of a closed object front and back lie upon each other.
    const std::string twoSided = transform(flat) + "<bsdf type=\"twosided\">" + kHalf + "</bsdf></shape>";
    expectGray(color(underSky("<shape type=\"cube\">" + twoSided)), 0.5f);
    expectGray(color(underSky("<shape type=\"obj\">" + file("cube.obj") + twoSided)), 0.5f);
    // Flattened first, then turned, moved and mirrored; the matrix as a whole.
    expectGray(color(underSky(
                   shape("obj", file("q.obj"), flat + R"(<rotate z="1" angle="30"/><translate z="-1"/>)"))),
               0.5f);
    expectGray(color(underSky(shape("obj", file("q.obj"), R"(<matrix value="1 0 0 0 1 0 0 0 0"/>)"))), 0.5f);
    EXPECT_THAT(load(underSky(shape("obj", file("q.obj"), flat))).warnings, IsEmpty());
    folder_.write("slanted.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nvn 1 0 0\nf 1//1 2//1 3//1\n");
    EXPECT_THAT(load(underSky(shape("obj", file("slanted.obj"), flat))).warnings,
                Contains(HasSubstr("3 of 3 vertex normals are undefined")));
}

TEST_F(Geometry, WhatIsLeftOfALineIsLeftOut) {
    folder_.write("q.obj", kQuadFile);
    for (const char* line : {R"(<scale x="1" y="0" z="0"/>)", R"(<scale value="0"/>)"})
        for (const std::string& scene : {shape("obj", file("q.obj"), line), shape("disk", "", line)}) {
            EXPECT_THAT(load(underSky(scene)).warnings, Contains(HasSubstr("left out")));
            expectGray(color(underSky(scene)), 1);
        }
    const std::string flat = R"(<scale z="0"/>)";
    for (const char* type : {"sphere", "cylinder"})
        EXPECT_THAT(error(underSky(shape(type, "", flat))), HasSubstr("singular")) << type;
}

/// Two squares that share an edge at this angle.
TriangleMesh hinge(float degrees) {
    TriangleMesh mesh;
    const float c = std::cos(radians(degrees)), s = std::sin(radians(degrees));
    mesh.positions = {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}, {c, 0, -s}, {c, 1, -s}};
    mesh.indices = {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2};
    return mesh;
}

TEST(MaxSmoothAngle, SplitsSharpEdges) {
    for (const auto& [edge, limit, vertices] :
         {std::tuple{40.0f, 30.0f, 8u}, {20.0f, 30.0f, 6u}, {90.0f, 100.0f, 6u}}) {
        TriangleMesh mesh = hinge(edge);
        splitAtSharpEdges(mesh, limit);
        EXPECT_EQ(mesh.positions.size(), vertices) << edge;
        const TriangleMesh before = hinge(edge);
        for (size_t i = 0; i < mesh.indices.size(); ++i)
            EXPECT_EQ(mesh.positions[mesh.indices[i]], before.positions[before.indices[i]]);
        mesh.computeVertexNormals();
        mesh.finalize();
        const float cosine = dot(mesh.normals[mesh.indices[1]], mesh.normals[mesh.indices[6]]);
        EXPECT_NEAR(cosine, edge > limit ? std::cos(radians(edge)) : 1.0f, 1e-5f);
    }
}

TEST(MaxSmoothAngle, JoinsVerticesThatAreEqual) {
    TriangleMesh mesh = hinge(20);
    std::vector<Vec3f> corners;
    for (const uint32_t v : mesh.indices) corners.push_back(mesh.positions[v]);
    mesh.positions = corners;
    for (uint32_t i = 0; i < mesh.indices.size(); ++i) mesh.indices[i] = i;
    splitAtSharpEdges(mesh, 30);
    EXPECT_EQ(mesh.positions.size(), 6u);
}

TEST(MaxSmoothAngle, KeepsAttributesAndSeams) {
    TriangleMesh mesh = hinge(40);
    mesh.uvs = {{0, 0}, {0.5f, 0}, {0.5f, 1}, {0, 1}, {1, 0}, {1, 1}};
    mesh.attributes = {{"vertex_tone", 1, {0, 1, 2, 3, 4, 5}}, {"face_tone", 1, {0, 1, 2, 3}}};
    splitAtSharpEdges(mesh, 30);
    ASSERT_EQ(mesh.positions.size(), 8u);
    mesh.finalize();  // checks all sizes
    const TriangleMesh before = hinge(40);
    for (size_t i = 0; i < mesh.indices.size(); ++i)
        EXPECT_EQ(mesh.attributes[0].values[mesh.indices[i]], static_cast<float>(before.indices[i]));
}

TEST_F(Geometry, MaxSmoothAngleOf06) {
    folder_.write("q.obj", kQuadFile);
    const std::string angle = R"(<float name="maxSmoothAngle" value="30"/>)";
    expectGray(color(underSky(shape("obj", file("q.obj") + angle, ""), "0.6.0")), 0.5f);
    const auto cube = [&](float degrees) {
        folder_.write("cube.obj", kCube);
        const std::string property = fmt::format(R"(<float name="maxSmoothAngle" value="{}"/>)", degrees);
        return load(underSky(shape("obj", file("cube.obj") + property, ""), "0.6.0"));
    };
    const auto vertices = [](const SceneParts& parts) {
        return dynamic_cast<const TriangleMesh&>(*parts.shapes.at(0)).positions.size();
    };
    EXPECT_EQ(vertices(cube(30)), 24u);
    EXPECT_EQ(vertices(cube(120)), 8u);
    EXPECT_THAT(error(underSky(shape("obj", file("q.obj") + angle, ""))), HasSubstr("maxSmoothAngle"));
    const std::string both = angle + R"(<boolean name="faceNormals" value="true"/>)";
    EXPECT_THAT(error(underSky(shape("obj", file("q.obj") + both, ""), "0.6.0")), HasSubstr("one of them"));
}

TEST_F(Geometry, HeightfieldsOf06) {
    const std::string slope = R"(<texture type="checkerboard"><rgb name="color0" value="1"/>
        <rgb name="color1" value="1"/></texture><integer name="width" value="8"/><integer name="height" value="4"/>)";
    const SceneParts parts =
        load(underSky(shape("heightfield", slope + R"(<float name="scale" value="0.25"/>)", "")));
    EXPECT_EQ(parts.shapes.at(0)->primitiveCount(), 2u * 7 * 3);
    EXPECT_NEAR(parts.shapes[0]->area(), 4, 1e-5f);
    Vec3f lower, upper;
    parts.shapes[0]->bounds(lower, upper);
    EXPECT_EQ(lower, Vec3f(-1, -1, 0.25f));
    EXPECT_EQ(upper, Vec3f(1, 1, 0.25f));
    expectGray(color(underSky(shape("heightfield", slope, ""), "0.6.0", 3)), 0.5f);
    // Heights 0 and 1 side by side (a row of two pixels, twice): a plane at 1 in 2.
    folder_.write("h.pgm", "P2\n2 2\n255\n0 255\n0 255\n");
    const SceneParts plane = load(underSky(shape("heightfield", file("h.pgm"), ""), "0.6.0"));
    EXPECT_NEAR(plane.shapes.at(0)->area(), 2 * std::sqrt(5.0f), 1e-4f);
    EXPECT_THAT(error(underSky(shape("heightfield", "", ""), "0.6.0")), HasSubstr("filename"));
}

TEST_F(Geometry, MergedShapesAreTheirParts) {
    const std::string parts = shape("cube", "", "") + shape("sphere", "", "");
    EXPECT_EQ(load(underSky("<shape type=\"merge\">" + parts + "</shape>")).shapes.size(), 2u);
    const std::string group = R"(<shape type="shapegroup" id="g"><shape type="merge">)" + parts +
                              R"(</shape></shape><shape type="instance"><ref id="g"/></shape>)";
    EXPECT_EQ(load(underSky(group)).instances.at(0).group->shapes.size(), 2u);
}

}  // namespace
}  // namespace metrolux::core::test
