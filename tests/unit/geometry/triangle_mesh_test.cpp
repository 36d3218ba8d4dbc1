#include "base/error.h"
#include "support.h"

namespace metrolux::core {
namespace {

/// The unit right triangle in the xy plane.
TriangleMesh triangle() {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.indices = {0, 1, 2};
    return mesh;
}

TEST(TriangleMesh, InterpolatesAttributes) {
    TriangleMesh mesh = triangle();
    mesh.attributes = {{"vertex_weight", 1, {1, 2, 4}},
                       {"vertex_color", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                       {"face_color", 3, {0.1f, 0.2f, 0.3f}}};
    mesh.finalize();
    SurfaceInteraction si;
    mesh.interaction(0, {0.5f, 0.25f}, si);
    expectNear(si.p, {0.5f, 0.25f, 0}, 1e-7f, "p");
    Rgb value;
    ASSERT_TRUE(mesh.attribute("vertex_weight", si, value));
    expectNear(value, Rgb(0.25f + 1 + 1), 1e-6f, "weight");
    ASSERT_TRUE(mesh.attribute("vertex_color", si, value));
    expectNear(value, Rgb(0.25f, 0.5f, 0.25f), 1e-6f, "color");
    ASSERT_TRUE(mesh.attribute("face_color", si, value));
    expectNear(value, Rgb(0.1f, 0.2f, 0.3f), 1e-6f, "face");
    EXPECT_FALSE(mesh.attribute("vertex_none", si, value));
    EXPECT_EQ(mesh.attributeChannels("vertex_weight"), 1);
    EXPECT_EQ(mesh.attributeChannels("face_color"), 3);
    EXPECT_EQ(mesh.attributeChannels("face_none"), 0);
}

TEST(TriangleMesh, NormalsFollowWindingThenVertexNormals) {
    SurfaceInteraction si;
    TriangleMesh mesh = triangle();
    mesh.finalize();
    mesh.interaction(0, {0.2f, 0.2f}, si);
    expectNear(si.ng, {0, 0, 1}, 1e-7f, "winding");
    mesh.flipNormals = true;
    mesh.finalize();
    mesh.interaction(0, {0.2f, 0.2f}, si);
    expectNear(si.ng, {0, 0, -1}, 1e-7f, "flipped");

    mesh.flipNormals = false;
    const Vec3f n = normalize(Vec3f(0.1f, 0, -1));
    mesh.normals = {n, n, n};
    mesh.finalize();
    mesh.interaction(0, {0.2f, 0.2f}, si);
    expectNear(si.ng, {0, 0, -1}, 1e-7f, "side of the vertex normals");
    expectNear(si.ns, n, 1e-6f, "ns");
    mesh.normals = {{1, 0, 1}, {0, 0, 1}, {0, 1, 1}};
    mesh.finalize();
    mesh.interaction(0, {0.5f, 0.25f}, si);
    expectNear(si.ns, normalize(Vec3f(0.25f, 0.25f, 1)), 1e-6f, "interpolated");
}

TEST(TriangleMesh, TangentsComeFromTextureCoordinates) {
    TriangleMesh mesh = triangle();
    mesh.uvs = {{0, 0}, {0, 2}, {4, 0}};  // u along y, v along x
    mesh.finalize();
    SurfaceInteraction si;
    mesh.interaction(0, {0.5f, 0.25f}, si);
    expectNear(partials(si).dpdu, {0, 0.25f, 0}, 1e-6f, "dpdu");
    expectNear(partials(si).dpdv, {0.5f, 0, 0}, 1e-6f, "dpdv");
    EXPECT_NEAR(si.uv.x, 1, 1e-6);
    EXPECT_NEAR(si.uv.y, 1, 1e-6);
    expectNear(si.s, {0, 1, 0}, 1e-6f, "s");
    mesh.uvs = {{1, 1}, {1, 1}, {1, 1}};
    mesh.interaction(0, {0.5f, 0.25f}, si);
    checkFrame(si);
    EXPECT_GT(partials(si).dpdu.length(), 0.5f);
}

TEST(TriangleMesh, SmoothNormalsAreWeightedByAngle) {
    // A cube whose corners are shared: faces of two triangles count once, so that the normals are the
    // diagonals.
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.emplace_back(i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f);
    mesh.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                    2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    mesh.computeVertexNormals();
    mesh.finalize();
    EXPECT_NEAR(mesh.area(), 24, 1e-5);
    for (size_t i = 0; i < 8; ++i)
        expectNear(mesh.normals[i], normalize(mesh.positions[i]), 1e-5f, "diagonal");
}

TEST(TriangleMesh, DegenerateTrianglesStayFinite) {
    TriangleMesh mesh = triangle();
    mesh.positions[2] = mesh.positions[1];
    mesh.computeVertexNormals();
    mesh.finalize();
    EXPECT_EQ(mesh.area(), 0);
    EXPECT_EQ(mesh.sampleArea({0.5f, 0.5f}).pdfArea, 0);
    SurfaceInteraction si;
    mesh.interaction(0, {0.3f, 0.3f}, si);
    checkFrame(si);
}

TEST(TriangleMesh, RefusesWhatIsInconsistent) {
    const auto refuses = [](auto&& damage) {
        TriangleMesh mesh = triangle();
        damage(mesh);
        EXPECT_THROW(mesh.finalize(), Error);
    };
    refuses([](TriangleMesh& m) { m.indices[1] = 3; });
    refuses([](TriangleMesh& m) { m.indices.pop_back(); });
    refuses([](TriangleMesh& m) { m.positions[0].y = NAN; });
    refuses([](TriangleMesh& m) { m.positions[0].y = kInfinity; });
    refuses([](TriangleMesh& m) { m.normals = {{0, 0, 1}}; });
    refuses([](TriangleMesh& m) { m.normals.assign(3, Vec3f(NAN)); });
    refuses([](TriangleMesh& m) { m.uvs.assign(2, Vec2f(0.0f)); });
    refuses([](TriangleMesh& m) { m.attributes = {{"vertex_a", 3, {1, 2}}}; });
    refuses([](TriangleMesh& m) { m.attributes = {{"face_a", 2, {1, 2}}}; });
}

}  // namespace
}  // namespace metrolux::core
