/// The scenes of the shared folder parse, with their includes, defaults and references.

#include "io/scene_loader.h"
#include "scene/scene.h"
#include "support.h"
#include "support/shared_data.h"

#include <algorithm>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

/// Fragments are scenes of their own syntactically, but refer to what the including file has.
std::vector<fs::path> sharedScenes() {
    std::vector<fs::path> files;
    for (const char* folder : {"scenes", "conformance"}) {
        const fs::path root = test::sharedPath(folder);
        for (const auto& entry : fs::recursive_directory_iterator(root))
            if (entry.path().extension() == ".xml" && entry.path().parent_path().filename() != "fragments")
                files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

TEST(SharedScenes, Parse) {
    METROLUX_NEEDS_SHARED(test::sharedPath("scenes"));
    METROLUX_NEEDS_SHARED(test::sharedPath("conformance"));
    const auto files = sharedScenes();
    ASSERT_GT(files.size(), 20u);
    for (const fs::path& file : files) {
        SCOPED_TRACE(file.string());
        mitsuba::ParsedScene parsed;
        ASSERT_NO_THROW(parsed = mitsuba::parseScene(file, {}));
        EXPECT_EQ(parsed.root->childrenOf("sensor").size(), 1u);
        EXPECT_EQ(parsed.root->childrenOf("integrator").size(), 1u);
        EXPECT_FALSE(parsed.root->childrenOf("shape").empty());
    }
}

TEST(SharedScenes, Load) {
    METROLUX_NEEDS_SHARED(test::sharedPath("scenes"));
    METROLUX_NEEDS_SHARED(test::sharedPath("conformance"));
    const auto files = sharedScenes();
    ASSERT_GT(files.size(), 20u);
    for (const fs::path& file : files) {
        SCOPED_TRACE(file.string());
        try {
            const Scene loaded(loadScene(file, {}));
            EXPECT_FALSE(loaded.lights().empty());
            EXPECT_FALSE(loaded.parts().shapes.empty() && loaded.parts().instances.empty());
            EXPECT_GT(loaded.bounds().radius, 0);
            for (const ShapePtr& shape : loaded.parts().shapes) EXPECT_TRUE(shape->bsdf) << shape->id;
        } catch (const std::exception& problem) {
            ADD_FAILURE() << problem.what();
        }
    }
}

TEST(SharedScenes, CornellBoxHasItsParts) {
    const fs::path file = test::sharedPath("scenes/cornell-box/scene.xml");
    METROLUX_NEEDS_SHARED(file);
    const auto parsed = mitsuba::parseScene(file, {{"max_depth", "7"}});
    EXPECT_EQ(parsed.root->childrenOf("integrator").at(0)->type, "path");
    EXPECT_EQ(parsed.root->childrenOf("integrator").at(0)->integer("max_depth", 0), 7);
    const auto sensor = parsed.root->childrenOf("sensor").at(0);
    EXPECT_FLOAT_EQ(sensor->number("fov", 0), 19.5f);
    EXPECT_FLOAT_EQ(static_cast<float>(sensor->transform("to_world").at(2, 3)), 6.8f);
    EXPECT_EQ(sensor->childrenOf("film").at(0)->integer("width", 0), 1024);
    const auto shapes = parsed.root->childrenOf("shape");
    ASSERT_EQ(shapes.size(), 8u);
    EXPECT_EQ(shapes[0]->childrenOf("bsdf").at(0)->id, "FloorBSDF");
    EXPECT_EQ(shapes[0]->childrenOf("bsdf").at(0)->childrenOf("bsdf").at(0)->type, "diffuse");
    EXPECT_TRUE(parsed.warnings.empty());
}

TEST(SharedScenes, LeftoversOfOldScenesAreWarnings) {
    const fs::path file = test::sharedPath("scenes/water-caustic/scene.xml");
    METROLUX_NEEDS_SHARED(file);
    const auto parsed = mitsuba::parseScene(file, {});
    int ignored = 0;
    for (const std::string& warning : parsed.warnings)
        ignored += warning.find("ignored") != std::string::npos;
    EXPECT_GE(ignored, 3);  // <mode>, two <hide>
    const auto water = parsed.root->childrenOf("shape").back();
    EXPECT_TRUE(water->boolean("face_normals", false));
    EXPECT_FLOAT_EQ(water->childrenOf("bsdf").at(0)->number("int_ior", 0), 1.8f);
}

}  // namespace
}  // namespace metrolux::core
