/// No output costs an input, another output, or a picture that somebody else made.

#include "command.h"
#include "image/image_io.h"
#include "paths.h"

#include <gmock/gmock.h>

#include <csignal>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OutputsTest : public CliTest {
  protected:
    /// Renders one pass with these words besides.
    Outcome render(const Words& words) const {
        return run(Words{"render", "textured.xml", "-i", "path", "--passes", "1", "--quiet"} + words);
    }
    /// A scene with a texture, a picture that this program has not written.
    OutputsTest() {
        ImageData image{2, 2, 3, std::vector<float>(12, 0.5f)};
        writePngRaw(folder / "texture.png", image);
        writeExr(folder / "texture.exr", image);
        write("textured.xml", R"(<scene version="3.0.0">
<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="8"/>
<integer name="height" value="8"/></film></sensor><emitter type="constant"/>
<shape type="sphere"><point name="center" x="0" y="0" z="4"/><bsdf type="diffuse">
<texture type="bitmap" name="reflectance"><string name="filename" value="texture.png"/></texture></bsdf></shape>
</scene>)");
    }
    std::string contentOf(const std::string& name) const {
        std::ifstream stream(folder / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
};

TEST_F(OutputsTest, NoOutputReplacesWhatTheRenderingReads) {
    fs::create_directory(folder / "sub");
    fs::create_symlink(folder / "texture.png", folder / "alias.png");
    fs::create_hard_link(folder / "texture.png", folder / "hard.png");
    const std::string before = contentOf("texture.png"), scene = contentOf("textured.xml");
    for (const char* name : {"texture.png", "./sub/../texture.png", "alias.png", "hard.png"}) {
        const Outcome outcome = render({"-o", name, "--overwrite"});
        EXPECT_EQ(outcome.status, 2) << name;
        EXPECT_THAT(outcome.err, HasSubstr("texture.png"));
        EXPECT_EQ(contentOf("texture.png"), before) << name;
    }
    for (const char* option : {"--stats", "--checkpoint"}) {
        EXPECT_EQ(render({"-o", "a.exr", option, "textured.xml"}).status, 2) << option;
        EXPECT_EQ(contentOf("textured.xml"), scene) << option;
    }
    // The file that keeps the checkpoint before the last.
    fs::rename(folder / "texture.png", folder / "c.1");
    write("textured.xml", std::string(scene).replace(scene.find("texture.png"), 11, "c.1"));
    EXPECT_EQ(render({"-o", "a.exr", "--checkpoint", "c"}).status, 2);
    EXPECT_EQ(contentOf("c.1"), before);
}

/// A kill between the two names of a checkpoint leaves them on one file.
TEST_F(OutputsTest, ACheckpointMayHaveTheNameOfTheOneBefore) {
    const Words checkpoint{"-o", "a.exr", "--checkpoint", "c"};
    ASSERT_EQ(render(checkpoint).status, 0);
    fs::create_hard_link(folder / "c", folder / "c.1");
    const Outcome resumed = run({"resume", "c", "--passes", "2"});
    EXPECT_EQ(resumed.status, 0) << resumed.err;
    EXPECT_FALSE(fs::equivalent(folder / "c", folder / "c.1"));
    fs::remove(folder / "c.1");
    fs::create_hard_link(folder / "c", folder / "c.1");
    EXPECT_EQ(render(checkpoint).status, 0);
}

TEST_F(OutputsTest, NoOutputReplacesAnother) {
    fs::create_symlink("a.exr", folder / "alias.exr");
    for (const Words& words :
         {Words{"-o", "a.exr", "-o", "./a.exr"}, Words{"-o", "a.exr", "-o", "alias.exr"},
          Words{"-o", "a.exr", "--stats", "a.exr"}, Words{"-o", "a.exr", "--checkpoint", "a.exr"},
          Words{"-o", "a.exr", "--stats", "c.1", "--checkpoint", "c"}}) {
        const Outcome outcome = render(words);
        EXPECT_EQ(outcome.status, 2) << words.back();
        EXPECT_THAT(outcome.err, HasSubstr("same file"));
    }
}

TEST_F(OutputsTest, PicturesOfOthersAreReplacedOnlyWhenToldTo) {
    for (const char* name : {"other.png", "other.exr"}) {
        fs::copy_file(folder / (std::string("texture") + fs::path(name).extension().string()), folder / name);
        const std::string before = contentOf(name);
        const Outcome outcome = render({"-o", name});
        EXPECT_EQ(outcome.status, 2) << name;
        EXPECT_THAT(outcome.err, HasSubstr("--overwrite"));
        EXPECT_EQ(contentOf(name), before);
        EXPECT_EQ(render({"-o", name, "--overwrite"}).status, 0);
        EXPECT_NE(contentOf(name), before);
        EXPECT_EQ(render({"-o", name}).status, 0) << "our own is replaced";
    }
    write("empty.png", "");
    EXPECT_EQ(render({"-o", "empty.png"}).status, 0) << "nobody's picture";
    const std::string before = contentOf("texture.png");
    ASSERT_EQ(render({"-o", "a.exr"}).status, 0);
    EXPECT_EQ(run({"compare", "a.exr", "a.exr", "--heatmap", "texture.png"}).status, 2);
    EXPECT_EQ(contentOf("texture.png"), before);
}

TEST_F(OutputsTest, WhatIsNoFileIsRefused) {
    ::mkfifo((folder / "fifo.exr").c_str(), 0600);
    fs::create_directory(folder / "folder.exr");
    fs::create_symlink("/dev/null", folder / "null.exr");
    for (const auto& [name, kind] : {std::pair("fifo.exr", "FIFO"), std::pair("folder.exr", "folder"),
                                     std::pair("null.exr", "device")}) {
        const Outcome outcome = render({"-o", name});
        EXPECT_EQ(outcome.status, 2) << name;
        EXPECT_THAT(outcome.err, HasSubstr(kind));
    }
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_EQ(render({"-o", "a.exr", "--stats", "/dev/null"}).status, 2);
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(OutputsTest, LinksAndPermissionsAreKept) {
    fs::create_directory(folder / "store");
    fs::create_symlink("store/a.exr", folder / "dangling.exr");
    ASSERT_EQ(render({"-o", "dangling.exr"}).status, 0);
    EXPECT_TRUE(fs::is_symlink(folder / "dangling.exr"));
    EXPECT_EQ(readImage(folder / "store/a.exr", false).width, 8);
    fs::permissions(folder / "store/a.exr", fs::perms::owner_read | fs::perms::owner_write);
    ASSERT_EQ(render({"-o", "dangling.exr"}).status, 0);
    EXPECT_TRUE(fs::is_symlink(folder / "dangling.exr"));
    EXPECT_EQ(fs::status(folder / "store/a.exr").permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(OutputsTest, ARescuedImageReplacesNothing) {
    write("metrolux-rescue-a.exr", "precious");
    fs::create_directory(folder / "gone");
    Command command(folder,
                    {"render", "scene.xml", "--time", "1h", "--save-every", "0.01s", "-o", "gone/a.exr"});
    ASSERT_TRUE(waitFor("gone/a.exr"));
    fs::rename(folder / "gone", folder / "renamed");
    command.signal(SIGINT);
    EXPECT_EQ(command.wait().status, 4);
    EXPECT_EQ(contentOf("metrolux-rescue-a.exr"), "precious");
    EXPECT_EQ(readImage(folder / "metrolux-rescue-1-a.exr", false).width, 24);
}

TEST_F(OutputsTest, ASecondProcessWithTheSameFilesIsTold) {
    const auto words = [](const char* image, const char* checkpoint) {
        return Words{"render", "scene.xml", "-i",  "path",         "--passes",
                     "2",      "-o",        image, "--checkpoint", checkpoint};
    };
    Command first(folder, {"render", "scene.xml", "-i", "path", "--time", "60s", "-o", "a.exr",
                           "--checkpoint", "c", "--checkpoint-every", "0.01s"});
    ASSERT_TRUE(waitFor("c"));
    const Outcome sameImage = run(words("a.exr", "d"));
    EXPECT_EQ(sameImage.status, 2);
    EXPECT_THAT(sameImage.err, HasSubstr("output 'a.exr' is being written by another process (process " +
                                         std::to_string(first.pid()) + ")"));
    const Outcome sameCheckpoint = run(words("b.exr", "c"));
    EXPECT_EQ(sameCheckpoint.status, 2);
    EXPECT_THAT(sameCheckpoint.err, HasSubstr("checkpoint 'c' is being written by another process"));
    EXPECT_EQ(run(words("b.exr", "d")).status, 0);
    first.signal(SIGKILL);
    first.wait();
    EXPECT_EQ(run(words("a.exr", "c")).status, 0) << "the system has freed the locks";
}

TEST_F(OutputsTest, APipeThatNobodyReadsEndsNothing) {
    // Messages go to a pipe whose reader is gone after the first line.
    const std::string command =
        "cd '" + folder.string() + "' && { '" + METROLUX_BINARY_DIR +
        "/metrolux' render scene.xml --passes 20 -o a.exr; echo $? > status; } 2>&1 | true";
    ASSERT_EQ(std::system(command.c_str()), 0);
    ASSERT_TRUE(waitFor("status"));
    EXPECT_EQ(contentOf("status"), "0\n");
    EXPECT_EQ(readImage(folder / "a.exr", false).width, 24);
}

TEST_F(OutputsTest, TimesAndErrorsHaveUnits) {
    EXPECT_EQ(render({"-o", "a.exr", "--save-every", "1m30s", "--error", "2%"}).status, 0);
    EXPECT_EQ(render({"-o", "a.exr", "--save-every", "0"}).status, 0);
    for (const Words& words : {Words{"--save-every", "1 minute"}, Words{"--save-every", "-1"},
                               Words{"--time", "1e30h"}, Words{"--error", "0"}, Words{"--error", "2 percent"},
                               Words{"--error", "nan"}, Words{"--time", "0"}}) {
        const Outcome outcome = render(Words{"-o", "a.exr"} + words);
        EXPECT_EQ(outcome.status, 2) << words[1];
        EXPECT_THAT(outcome.err, HasSubstr(words[1]));
    }
}

}  // namespace
}  // namespace metrolux::core::cli
