// Every mesh of the shared scenes can be read and is sound.
#include "base/error.h"
#include "io/mesh_io.h"
#include "support/shared_data.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

void checkSound(const TriangleMesh& mesh) {
    EXPECT_GT(mesh.area(), 0);
    EXPECT_GT(mesh.primitiveCount(), 0u);
    for (uint32_t i = 0; i < mesh.primitiveCount(); ++i) {
        SurfaceInteraction si;
        mesh.interaction(i, {0.3f, 0.3f}, si);
        ASSERT_NEAR(lengthSquared(si.ng), 1, 1e-5);
        ASSERT_NEAR(lengthSquared(si.ns), 1, 1e-5);
        ASSERT_NEAR(lengthSquared(si.s), 1, 1e-5);
        ASSERT_NEAR(dot(si.s, si.ns), 0, 1e-5);
        ASSERT_TRUE(isFinite(si.p) && isFinite(partials(si).dpdu) && isFinite(partials(si).dpdv));
    }
}

TEST(SharedMeshes, AllAreRead) {
    METROLUX_NEEDS_SHARED(test::sharedPath(""));
    size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(test::sharedPath(""))) {
        const fs::path& path = entry.path();
        SCOPED_TRACE(path.string());
        std::shared_ptr<TriangleMesh> mesh;
        if (path.extension() == ".obj")
            mesh = readObj(path, {});
        else if (path.extension() == ".ply")
            mesh = readPly(path, {});
        else if (path.extension() == ".serialized")
            mesh = readSerialized(path, 1, {});  // through the table of offsets
        else
            continue;
        ++count;
        checkSound(*mesh);
    }
    EXPECT_GT(count, 10u);
}

/// 3 MB are far below half a second; the limit leaves room for slow machines and sanitizers.
TEST(SharedMeshes, LargeFilesAreReadFast) {
    const fs::path obj = test::sharedPath("conformance/common/meshes/sphere.obj");
    const fs::path ply = test::sharedPath("scenes/water-caustic/models/Mesh001.ply");
    METROLUX_NEEDS_SHARED(obj);
    METROLUX_NEEDS_SHARED(ply);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(readObj(obj, {})->primitiveCount(), 32512u);
    EXPECT_EQ(readPly(ply, {})->primitiveCount(), 102938u);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5);
}

TEST(SharedMeshes, SphereAttributesHaveMitsubasNames) {
    const fs::path path =
        test::sharedPath("conformance/tests/scenes/mesh_attributes/meshes/sphere_attribute.ply");
    METROLUX_NEEDS_SHARED(path);
    const auto mesh = readPly(path, {});
    EXPECT_EQ(mesh->attributeChannels("vertex_color"), 3);
    EXPECT_EQ(mesh->attributeChannels("face_color"), 3);
    EXPECT_EQ(mesh->attributeChannels("face_weight"), 1);
}

}  // namespace
}  // namespace metrolux::core
