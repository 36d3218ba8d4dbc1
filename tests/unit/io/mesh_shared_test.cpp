// Every mesh of the shared scenes can be read and is sound.
#include "base/error.h"
#include "io/mesh_io.h"
#include "paths.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

const fs::path kShared = METROLUX_SHARED_DIR;

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
    if (!fs::exists(kShared)) GTEST_SKIP() << kShared << " is absent";
    size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(kShared)) {
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
    const fs::path obj = kShared / "conformance/common/meshes/sphere.obj";
    const fs::path ply = kShared / "scenes/water-caustic/models/Mesh001.ply";
    if (!fs::exists(obj) || !fs::exists(ply)) GTEST_SKIP() << kShared << " is absent";
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(readObj(obj, {})->primitiveCount(), 32512u);
    EXPECT_EQ(readPly(ply, {})->primitiveCount(), 102938u);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5);
}

TEST(SharedMeshes, SphereAttributesHaveMitsubasNames) {
    const fs::path path = kShared / "conformance/tests/scenes/mesh_attributes/meshes/sphere_attribute.ply";
    if (!fs::exists(path)) GTEST_SKIP() << path << " is absent";
    const auto mesh = readPly(path, {});
    EXPECT_EQ(mesh->attributeChannels("vertex_color"), 3);
    EXPECT_EQ(mesh->attributeChannels("face_color"), 3);
    EXPECT_EQ(mesh->attributeChannels("face_weight"), 1);
}

}  // namespace
}  // namespace metrolux::core
