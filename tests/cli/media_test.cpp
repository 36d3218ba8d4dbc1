/// What holds for surfaces holds in media: the same bits on any number of threads, after being resumed, and
/// from slices.

#include "cli/command.h"
#include "image/image_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core::cli {
namespace {

class MediaTest : public CliTest {
  protected:
    MediaTest() {
        std::string scene = kTinyScene;
        scene.insert(scene.rfind("</scene>"), R"(
    <shape type="cube">
        <transform name="to_world"><scale value="6"/></transform>
        <bsdf type="null"/>
        <medium name="interior" type="homogeneous">
            <rgb name="sigma_t" value="0.2, 0.15, 0.3"/><rgb name="albedo" value="0.9"/>
        </medium>
    </shape>
)");
        write("scene.xml", scene);
    }
    static std::vector<Words> renderings() {
        return {{"-i", "path"},
                {"-i", "vcm", "--medium-radius", "0.2"},
                {"-i", "mcmc_vcm", "--fixed", "--medium-radius", "0.2"},
                {"-i", "mcmc_vcm", "--memory", "300k"},
                {"-i", "pssmlt"}};
    }
    static Words common(const Words& options) {
        return Words{"render", "scene.xml", "--resolution", "24x18", "--seed", "5"} + options;
    }
};

TEST_F(MediaTest, AnyNumberOfThreadsMakesTheSameBits) {
    for (const Words& options : renderings()) {
        SCOPED_TRACE(testing::PrintToString(options));
        for (const char* threads : {"1", "2", "7"}) {
            const Outcome outcome =
                run(common(options) + Words{"--passes", "6", "--threads", threads, "-o",
                                            std::string(threads) + ".exr", "--overwrite"});
            ASSERT_EQ(outcome.status, 0) << outcome.err;
        }
        EXPECT_EQ(pixels("1.exr"), pixels("2.exr"));
        EXPECT_EQ(pixels("1.exr"), pixels("7.exr"));
    }
}

TEST_F(MediaTest, EveryPassCanBeTheLast) {
    for (const Words& options : renderings()) {
        SCOPED_TRACE(testing::PrintToString(options));
        ASSERT_EQ(run(common(options) + Words{"--passes", "8", "-o", "expected.exr"}).status, 0);
        ASSERT_EQ(run(common(options) + Words{"--passes", "1", "-o", "a.exr", "--checkpoint", "c"}).status,
                  0);
        for (int passes : {2, 5, 8})
            ASSERT_EQ(run({"resume", "c", "--passes", std::to_string(passes)}).status, 0);
        EXPECT_EQ(pixels("a.exr"), pixels("expected.exr"));
    }
}

TEST_F(MediaTest, SlicesEqualTheWhole) {
    for (const Words& options : renderings()) {
        SCOPED_TRACE(testing::PrintToString(options));
        const Words words = common(options) + Words{"--passes", "7", "--slices", "3"};
        ASSERT_EQ(run(words + Words{"-o", "whole.exr"}).status, 0);
        ASSERT_EQ(run(words + Words{"--only-slices", "0-1", "--checkpoint", "first"}).status, 0);
        ASSERT_EQ(run(words + Words{"--only-slices", "2", "--checkpoint", "second"}).status, 0);
        ASSERT_EQ(run({"merge", "second", "first", "-o", "merged.exr"}).status, 0);
        EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr"));
    }
}

/// The fog is in the image, and not in the layers that say what is seen: its boundary is no surface.
TEST_F(MediaTest, ShowsInTheImageAndNotAsASurface) {
    const auto render = [&](const std::string& image) {
        return run(common({"-i", "path", "--passes", "4", "-o", image, "--aov", "albedo,normal,depth"}))
            .status;
    };
    ASSERT_EQ(render("fog.exr"), 0);
    write("scene.xml", kTinyScene);
    ASSERT_EQ(render("clear.exr"), 0);
    EXPECT_NE(pixels("fog.exr"), pixels("clear.exr"));
    for (const char* layer : {"albedo", "normal", "depth"})
        EXPECT_EQ(readLayer(folder / "fog.exr", layer).pixels, readLayer(folder / "clear.exr", layer).pixels)
            << layer;
}

}  // namespace
}  // namespace metrolux::core::cli
