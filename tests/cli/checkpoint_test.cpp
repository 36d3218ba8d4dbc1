/// Checkpoints as a user meets them: processes that are killed, files that are damaged, disks that are full.

#include "render/checkpoint.h"

#include "base/error.h"
#include "base/rng.h"
#include "command.h"
#include "image/image_io.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <sys/mount.h>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string bytesOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

class CheckpointTest : public CliTest {
  protected:
    /// A rendering of so many passes with a checkpoint after each.
    static Words renderWords(const std::string& integrator, int passes) {
        return {"render",
                "scene.xml",
                "-i",
                integrator,
                "--resolution",
                "24x18",
                "--passes",
                std::to_string(passes),
                "-o",
                "a.exr",
                "--checkpoint",
                "c",
                "--checkpoint-every",
                "0.000001s"};
    }
    static Words plainWords(const std::string& integrator, int passes) {
        return {"render",       "scene.xml",   "-i",       integrator,
                "--resolution", "24x18",       "--passes", std::to_string(passes),
                "-o",           "expected.exr"};
    }
    /// A checkpoint `c` after 4 passes of 4, by path tracing.
    void makeCheckpoint() {
        const Outcome outcome = run(renderWords("path", 4));
        ASSERT_EQ(outcome.status, 0) << outcome.err;
    }
    void expectRefused(const Words& words, const std::string& message) const {
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.status, 2) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(message));
    }
};

/// Kills of each rendering; `make soak-checkpoint` asks for more.
int killsOfEach() {
    const char* text = std::getenv("METROLUX_KILLS");
    return text ? std::atoi(text) : 1;
}

struct KillTest : CheckpointTest, testing::WithParamInterface<std::string> {
    /// Kills a rendering so long after its first checkpoint; passes of the last one.
    uint32_t killAfter(double seconds, int passes) const {
        for (const char* file : {"a.exr", "c", "c.1"}) fs::remove(folder / file);
        Command command(folder, renderWords(GetParam(), passes));
        const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
        while (!fs::exists(folder / "c") && std::chrono::steady_clock::now() < limit)
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
        command.signal(SIGKILL);
        command.wait();
        return readCheckpoint(folder / "c", METROLUX_TEST_VERSION).slices.at(0).passes;
    }
};

TEST_P(KillTest, ResumedImageIsThatOfARunThatWasNeverStopped) {
    constexpr uint32_t kPasses = 20;
    ASSERT_EQ(run(renderWords(GetParam(), kPasses)).status, 0);
    const double seconds = readCheckpoint(folder / "c", METROLUX_TEST_VERSION).seconds;
    ASSERT_EQ(run(plainWords(GetParam(), kPasses)).status, 0);
    const std::vector<float> expected = pixels("expected.exr");
    EXPECT_EQ(pixels("a.exr"), expected) << "checkpoints may not change the image";

    const auto seed = static_cast<uint64_t>(::getpid());
    RecordProperty("seed", std::to_string(seed));
    CounterRng rng(seed);
    // A busy machine may let it finish before the signal arrives: such a kill does not count.
    const int kills = killsOfEach();
    int midway = 0;
    for (int attempt = 0; attempt < 20 * kills && midway < kills; ++attempt) {
        const uint32_t passes = killAfter(seconds * rng.nextDouble(), kPasses);
        midway += passes < kPasses;
        std::cout << GetParam() << ": killed after pass " << passes << '\n';
        fs::remove(folder / "a.exr");
        const Outcome outcome = run({"resume", "c"});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(pixels("a.exr"), expected) << "killed after pass " << passes;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder))
            EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr(".tmp"))) << "left by the killed one";
    }
    EXPECT_EQ(midway, kills) << "no kill came before the end";
}

INSTANTIATE_TEST_SUITE_P(Integrators, KillTest, testing::ValuesIn(integratorNames()));

TEST_F(CheckpointTest, EveryPassCanBeTheLast) {
    // Stopped by its limit after each number of passes, and continued beyond it. Method A has a state of its
    // own.
    for (const Words& options : {Words{"-i", "mcmc_vcm"}, Words{"-i", "pssmlt_merge", "--method", "A"},
                                 Words{"-i", "mcmc_vcm", "--split", "auto"},
                                 Words{"-i", "mcmc_vcm", "--memory", "300k", "--kernel", "adaptive"}}) {
        const Words common = Words{"render", "scene.xml", "--resolution", "24x18", "--seed", "5"} + options;
        ASSERT_EQ(run(common + Words{"--passes", "8", "-o", "expected.exr"}).status, 0);
        ASSERT_EQ(run(common + Words{"--passes", "1", "-o", "a.exr", "--checkpoint", "c"}).status, 0);
        for (int passes : {2, 3, 5, 8})
            ASSERT_EQ(run({"resume", "c", "--passes", std::to_string(passes)}).status, 0);
        EXPECT_EQ(pixels("a.exr"), pixels("expected.exr")) << testing::PrintToString(options);
    }
}

/// Another compiler or processor might round differently: the image would be neither's.
TEST_F(CheckpointTest, AnotherBuildIsRefusedUnlessAskedFor) {
    makeCheckpoint();
    Checkpoint checkpoint = readCheckpoint(folder / "c", METROLUX_TEST_VERSION);
    nlohmann::json identity = nlohmann::json::parse(checkpoint.identity);
    ASSERT_TRUE(identity["build"].contains("compiler"));
    identity["build"]["compiler"] = "GCC 99";
    identity["build"]["rays_in_a_packet"] = 2;
    checkpoint.identity = identity.dump();
    writeCheckpoint(folder / "c", checkpoint);
    const Outcome refused = run({"resume", "c", "--passes", "6"});
    EXPECT_EQ(refused.status, 2);
    for (const char* text : {"written by another build", "/compiler: found", "expected \"GCC 99\"",
                             "/rays_in_a_packet", "--other-build"})
        EXPECT_THAT(refused.err, HasSubstr(text));
    const Outcome allowed = run({"resume", "c", "--passes", "6", "--other-build"});
    EXPECT_EQ(allowed.status, 0) << allowed.err;
    const Outcome own = run({"resume", "c", "--passes", "8"});
    EXPECT_EQ(own.status, 0) << "what it has written is its own: " << own.err;
}

TEST_F(CheckpointTest, TheLastTwoAreKept) {
    makeCheckpoint();
    for (const auto& [file, passes] : {std::pair{"c", 4u}, {"c.1", 4u}})
        EXPECT_LE(readCheckpoint(folder / file, METROLUX_TEST_VERSION).slices.at(0).passes, passes);
    ASSERT_EQ(run(plainWords("path", 12)).status, 0);
    fs::remove(folder / "c");
    expectRefused({"resume", "c"}, "but there is 'c.1'");
    ASSERT_EQ(run({"resume", "c.1", "--passes", "12"}).status, 0);
    EXPECT_EQ(pixels("a.exr"), pixels("expected.exr"));
    EXPECT_EQ(readCheckpoint(folder / "c", METROLUX_TEST_VERSION).slices.at(0).passes, 12u);
}

TEST_F(CheckpointTest, LimitsCountWhatWasRenderedBefore) {
    ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--time", "0.6s", "-o", "a.exr", "--checkpoint", "c"})
                  .status,
              0);
    ASSERT_EQ(run({"resume", "c", "--time", "1s", "-o", "b.exr"}).status, 0);
    const Checkpoint after = readCheckpoint(folder / "c", METROLUX_TEST_VERSION);
    EXPECT_GT(after.seconds, 0.9);
    EXPECT_LT(after.seconds, 1.5);
    // Nothing is left to do: the files are written again.
    fs::remove(folder / "b.exr");
    ASSERT_EQ(run({"resume", "c"}).status, 0);
    EXPECT_EQ(readCheckpoint(folder / "c", METROLUX_TEST_VERSION).slices.at(0).passes,
              after.slices.at(0).passes);
    EXPECT_TRUE(fs::exists(folder / "b.exr"));
}

TEST_F(CheckpointTest, DamagedFilesAreRefused) {
    makeCheckpoint();
    fs::remove(folder / "c.1");
    const std::string good = bytesOf(folder / "c");
    write("c", good.substr(0, good.size() - 1));
    expectRefused({"resume", "c"},
                  fmt::format("damaged: found {} bytes, expected {}", good.size() - 1, good.size()));
    write("c", good + '\0');
    expectRefused({"resume", "c"}, "damaged");
    write("c", "");
    expectRefused({"resume", "c"}, "not a checkpoint");
    CounterRng rng(1);
    for (size_t i = 0; i < 500; ++i) {
        std::string bad = good;
        const size_t at = i < 100 ? i : rng.nextBits() % good.size();
        bad[at] = static_cast<char>(bad[at] ^ (1 << rng.nextBits() % 8));
        EXPECT_THROW(parseCheckpoint(bad, "bad", METROLUX_TEST_VERSION), Error) << at;
        if (i % 125 != 0) continue;
        write("c", bad);
        expectRefused({"resume", "c"}, "'c'");
    }
    write("c", good);
    EXPECT_EQ(run({"resume", "c"}).status, 0);
    // The one before is named where there is one.
    write("c", good.substr(1));
    write("c.1", good);
    expectRefused({"resume", "c"}, "the one before it is 'c.1'");
}

TEST_F(CheckpointTest, OtherScenesAndVersionsAreRefused) {
    makeCheckpoint();
    std::string scene = kTinyScene;
    scene.replace(scene.find("0.3, 0.5, 0.7"), 13, "0.3, 0.5, 0.8");
    write("scene.xml", scene);
    expectRefused({"resume", "c"}, "scene/files/scene.xml: found ");
    write("scene.xml", kTinyScene);
    EXPECT_EQ(run({"resume", "c"}).status, 0);

    Checkpoint other = readCheckpoint(folder / "c", METROLUX_TEST_VERSION);
    other.version = "9.9.9";
    writeCheckpoint(folder / "other", other);
    expectRefused({"resume", "other"}, "written by version 9.9.9");
    other.version = METROLUX_TEST_VERSION;
    other.command.push_back("--max-depth=3");
    writeCheckpoint(folder / "other", other);
    expectRefused({"resume", "other"}, "algorithm/max_depth: found 3, expected 8");
    expectRefused({"resume", "absent"}, "no such file");
    expectRefused({"resume", "scene.xml"}, "not a checkpoint");
}

TEST_F(CheckpointTest, FilesOfTheSceneArePartOfIt) {
    std::string scene = kTinyScene;
    const std::string color = "<rgb name=\"reflectance\" value=\"0.3, 0.5, 0.7\"/>";
    scene.replace(scene.find(color), color.size(), R"(<spectrum name="reflectance" filename="a.spd"/>)");
    scene.replace(scene.find("    <shape type=\"sphere\">"), 0, "    <include filename=\"part.xml\"/>\n");
    write("scene.xml", scene);
    write("a.spd", "400 0.5\n700 0.5\n");
    write(
        "part.xml",
        R"(<scene version="3.0.0"><shape type="obj"><string name="filename" value="a.obj"/></shape></scene>)");
    write("a.obj", "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n");
    makeCheckpoint();
    for (const auto& [file, change] :
         {std::pair{"a.spd", "400 0.6\n700 0.5\n"}, {"a.obj", "v 0 0 1\nv 1 0 1\nv 0 2 1\nf 1 2 3\n"}}) {
        const std::string before = bytesOf(folder / file);
        write(file, change);
        expectRefused({"resume", "c"}, fmt::format("scene/files/{}: found", file));
        write(file, before);
    }
    EXPECT_EQ(run({"resume", "c"}).status, 0);
}

TEST_F(CheckpointTest, ASecondRenderingWarnsThatItReplacesOne) {
    makeCheckpoint();
    const Outcome outcome = run(renderWords("path", 4));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.err, HasSubstr("metrolux resume c"));
}

TEST_F(CheckpointTest, WhatCannotBeWrittenAtTheStartIsAnError) {
    expectRefused({"render", "scene.xml", "--time", "1h", "--checkpoint", "absent/c"}, "absent");
    expectRefused({"render", "scene.xml", "--time", "1h", "--checkpoint-every", "1m"}, "--checkpoint FILE");
}

TEST_F(CheckpointTest, RendersOnWhenTheFolderVanishesAndTriesAgain) {
    fs::create_directory(folder / "gone");
    const Words words{
        "render", "scene.xml",          "-i",   "path", "--time", "1h", "-o", "a.exr", "--checkpoint",
        "gone/c", "--checkpoint-every", "0.02s"};
    Command command(folder, words);
    ASSERT_TRUE(waitFor("gone/c"));
    fs::rename(folder / "gone", folder / "away");
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    // Somebody mounts it again.
    fs::create_directory(folder / "gone");
    ASSERT_TRUE(waitFor("gone/c"));
    command.signal(SIGINT);
    const Outcome again = command.wait();
    EXPECT_EQ(again.status, 3) << again.err;
    EXPECT_THAT(again.err, HasSubstr("checkpoint: cannot write"));
    EXPECT_EQ(run({"resume", "gone/c", "--passes", "1"}).status, 0);

    fs::remove(folder / "gone/c");
    // It stays away: the image is there, and the status says that something is not.
    Command last(folder, words);
    ASSERT_TRUE(waitFor("gone/c"));
    fs::rename(folder / "gone", folder / "away2");
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    last.signal(SIGINT);
    const Outcome lost = last.wait();
    EXPECT_EQ(lost.status, 4) << lost.err;
    EXPECT_THAT(lost.err, HasSubstr("the last checkpoint was not written"));
    EXPECT_EQ(readImage(folder / "a.exr", false).width, 24);
    EXPECT_NO_THROW(readCheckpoint(folder / "away2" / "c", METROLUX_TEST_VERSION));
}

/// A file system of its own in `folder/disk`, if this process may mount one.
class Disk {
  public:
    Disk(const fs::path& folder, const std::string& options) : path_(folder / "disk") {
        fs::create_directories(path_);
        mounted_ = ::mount("tmpfs", path_.c_str(), "tmpfs", 0, options.c_str()) == 0;
    }
    ~Disk() {
        if (mounted_) ::umount2(path_.c_str(), MNT_DETACH);
    }
    bool mounted() const { return mounted_; }
    bool makeReadOnly() const {
        return ::mount("tmpfs", path_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr) == 0;
    }

  private:
    fs::path path_;
    bool mounted_ = false;
};

TEST_F(CheckpointTest, AFullDiskLosesNothing) {
    // One checkpoint of some 40 kB fits, two do not.
    const Disk disk(folder, "size=72k");
    if (!disk.mounted()) GTEST_SKIP() << "this process may not mount a tmpfs";
    Words words = renderWords("path", 6);
    std::replace(words.begin(), words.end(), std::string("c"), std::string("disk/c"));
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 4) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("No space left on device"));
    ASSERT_EQ(run(plainWords("path", 6)).status, 0);
    EXPECT_EQ(pixels("a.exr"), pixels("expected.exr"));
    // The first one is whole.
    EXPECT_EQ(readCheckpoint(folder / "disk/c", METROLUX_TEST_VERSION).slices.at(0).passes, 1u);
    fs::copy_file(folder / "disk/c", folder / "disk-c");
    fs::remove(folder / "a.exr");
    EXPECT_EQ(run({"resume", "disk-c"}).status, 4);
    EXPECT_EQ(pixels("a.exr"), pixels("expected.exr"));
}

TEST_F(CheckpointTest, AFolderThatBecomesReadOnlyLosesNothing) {
    const Disk disk(folder, "size=10m");
    if (!disk.mounted()) GTEST_SKIP() << "this process may not mount a tmpfs";
    Command command(folder, {"render", "scene.xml", "-i", "path", "--time", "1h", "-o", "a.exr",
                             "--checkpoint", "disk/c", "--checkpoint-every", "0.02s"});
    ASSERT_TRUE(waitFor("disk/c"));
    // Busy while a file is open for writing.
    bool readOnly = false;
    for (int i = 0; i < 1000 && !readOnly; ++i) {
        readOnly = disk.makeReadOnly();
        if (!readOnly) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    ASSERT_TRUE(readOnly);
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    command.signal(SIGINT);
    const Outcome outcome = command.wait();
    EXPECT_EQ(outcome.status, 4) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("Read-only file system"));
    EXPECT_NO_THROW(readCheckpoint(folder / "disk/c", METROLUX_TEST_VERSION));
    EXPECT_GT(pixels("a.exr").size(), 0u);
}

TEST_F(CheckpointTest, AFileSizeLimitIsAnErrorAndNotTheEnd) {
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    rlimit small = before;
    small.rlim_cur = 20000;  // the image fits, the checkpoint does not
    ::setrlimit(RLIMIT_FSIZE, &small);
    const Outcome outcome = run(renderWords("path", 3));
    ::setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(outcome.status, 4) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("File too large"));
    EXPECT_EQ(readImage(folder / "a.exr", false).width, 24);
    EXPECT_FALSE(fs::exists(folder / "c"));
}

}  // namespace
}  // namespace metrolux::core::cli
