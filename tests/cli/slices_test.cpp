/// Renderings that are divided: over processes by hand, and over ranks of MPI.

#include "command.h"
#include "image/image_io.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class SlicesTest : public CliTest {
  protected:
    /// 22 passes in 8 slices: some have one more than others.
    static Words words(const std::string& integrator) {
        return {"render",   "scene.xml", "-i",       integrator, "--resolution", "24x18",
                "--passes", "22",        "--slices", "8",        "--seed",       "3"};
    }
    Outcome part(const std::string& integrator, const std::string& slices, const std::string& name) const {
        return run(words(integrator) + Words{"--only-slices", slices, "--checkpoint", name});
    }
    static bool haveMpi() { return METROLUX_TEST_MPI && std::system("command -v mpirun > /dev/null") == 0; }
    static Words mpirun(int ranks) {
        Words words{"mpirun", "--allow-run-as-root", "--oversubscribe", "-n", std::to_string(ranks)};
#ifdef __SANITIZE_ADDRESS__
        // Threads and plugins of OpenMPI never free some blocks, and a suppression cannot name plugins that
        // are unloaded at the end. Leaks of ours show in the other tests.
        words.insert(words.end(), {"-x", "ASAN_OPTIONS=detect_leaks=0"});
#endif
        return words;
    }
    Outcome runRanks(int ranks, const Words& arguments) const {
        return Command(folder, arguments, mpirun(ranks)).wait();
    }
};

TEST_F(SlicesTest, FourPartsEqualTheWhole) {
    for (const char* integrator : {"path", "vcm", "mcmc_vcm", "pssmlt"}) {
        ASSERT_EQ(run(words(integrator) + Words{"-o", "whole.exr", "--aov", "variance"}).status, 0);
        Words merge{"merge"};
        // In any order.
        for (const char* slices : {"6-7", "0-2", "5", "3-4"}) {
            const Outcome outcome = part(integrator, slices, std::string("part") + slices);
            ASSERT_EQ(outcome.status, 0) << outcome.err;
            merge.push_back(std::string("part") + slices);
        }
        const Outcome outcome =
            run(merge + Words{"-o", "merged.exr", "--aov", "variance", "--stats", "a.json"});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr")) << integrator;
        EXPECT_EQ(readLayer(folder / "merged.exr", "variance").pixels,
                  readLayer(folder / "whole.exr", "variance").pixels)
            << integrator;
        const nlohmann::json s = nlohmann::json::parse(std::ifstream(folder / "a.json"));
        EXPECT_EQ(s["passes"], 22);
        EXPECT_EQ(s["passes_of_slices"]["5"], 3);
        EXPECT_EQ(s["passes_of_slices"]["6"], 2);
        EXPECT_TRUE(s["missing_slices"].empty());
    }
}

TEST_F(SlicesTest, TheNamesOfTheOptionsBefore0_3StillWork) {
    const auto render = [&](const char* slices, const char* only, const char* name) {
        return run({"render", "scene.xml", "-i", "path", "--passes", "4", slices, "2", only, "1",
                    "--checkpoint", name});
    };
    ASSERT_EQ(render("--slices", "--only-slices", "new").status, 0);
    const Outcome old = render("--streams", "--only-streams", "old");
    ASSERT_EQ(old.status, 0) << old.err;
    for (const char* name : {"new", "old"})
        ASSERT_EQ(run({"merge", name, "-o", std::string(name) + ".exr"}).status, 0);
    EXPECT_EQ(pixels("old.exr"), pixels("new.exr"));
    EXPECT_EQ(render("--streams", "--only-slices", "mixed").status, 0);
    EXPECT_EQ(run({"render", "scene.xml", "--slices", "2", "--streams", "2"}).status, 2);
}

TEST_F(SlicesTest, SlicesAreAnotherImageThanOneSliceAndThanEachOther) {
    ASSERT_EQ(run(words("path") + Words{"-o", "eight.exr"}).status, 0);
    ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--resolution", "24x18", "--passes", "22", "--seed",
                   "3", "-o", "one.exr"})
                  .status,
              0);
    EXPECT_NE(pixels("eight.exr"), pixels("one.exr"));
    for (const char* slice : {"6", "7"}) {
        ASSERT_EQ(part("path", slice, std::string("p") + slice).status, 0);
        ASSERT_EQ(run({"merge", std::string("p") + slice, "-o", std::string(slice) + ".exr"}).status, 0);
    }
    EXPECT_NE(pixels("6.exr"), pixels("7.exr"));
}

TEST_F(SlicesTest, PartsThatDoNotBelongTogetherAreRefused) {
    ASSERT_EQ(part("path", "0-3", "a").status, 0);
    ASSERT_EQ(part("path", "3-7", "overlapping").status, 0);
    ASSERT_EQ(part("vcm", "4-7", "integrator").status, 0);
    ASSERT_EQ(run(words("path") + Words{"--only-slices", "4-7", "--checkpoint", "depth", "--max-depth", "3"})
                  .status,
              0);
    std::string scene = kTinyScene;
    scene.replace(scene.find("0.3, 0.5, 0.7"), 13, "0.3, 0.5, 0.8");
    write("scene.xml", scene);
    ASSERT_EQ(part("path", "4-7", "scene").status, 0);
    const std::vector<std::pair<std::string, std::string>> cases{
        {"a", "slice 0 is in 'a' and in 'a'"},
        {"overlapping", "slice 3 is in 'a' and in 'overlapping'"},
        {"integrator", "algorithm/integrator: found \"vcm\", expected \"path\""},
        {"depth", "algorithm/max_depth: found 3, expected 8"},
        {"scene", "scene/files/scene.xml"},
    };
    for (const auto& [other, message] : cases) {
        const Outcome outcome = run({"merge", "a", other, "-o", "merged.exr"});
        EXPECT_EQ(outcome.status, 2) << other;
        EXPECT_THAT(outcome.err, HasSubstr(message)) << other;
    }
    const Outcome missing = run({"merge", "a", "-o", "merged.exr"});
    EXPECT_EQ(missing.status, 0);
    EXPECT_THAT(missing.err, HasSubstr("4 of 8 slices are missing: 4, 5, 6, 7"));
    EXPECT_EQ(run({"merge", "a"}).status, 2) << "no image is named";
}

TEST_F(SlicesTest, OptionsThatCannotBeAreRefused) {
    const std::vector<std::pair<Words, std::string>> cases{
        {{"--only-slices", "0-3", "--checkpoint", "c"}, "--slices S"},
        {{"--slices", "8", "--only-slices", "0-3"}, "--checkpoint FILE"},
        {{"--slices", "8", "--only-slices", "0-8", "--checkpoint", "c"}, "expected 0 to 7"},
        {{"--slices", "8", "--only-slices", "3-1", "--checkpoint", "c"}, "'3-1' is not a range"},
        {{"--slices", "8", "--only-slices", "3", "--checkpoint", "c", "--error", "0.1"}, "--error"},
        {{"--slices", "8", "--only-slices", "7", "--checkpoint", "c", "--passes", "7"}, "found 7 passes"},
    };
    for (const auto& [options, message] : cases) {
        const Outcome outcome = run(Words{"render", "scene.xml"} + options);
        EXPECT_EQ(outcome.status, 2) << testing::PrintToString(options);
        EXPECT_THAT(outcome.err, HasSubstr(message));
    }
}

TEST_F(SlicesTest, SlicesAreResumedAndTakeTurnsUnderATimeLimit) {
    ASSERT_EQ(run(words("mcmc_vcm") + Words{"-o", "whole.exr"}).status, 0);
    Words shorter = words("mcmc_vcm");
    std::replace(shorter.begin(), shorter.end(), std::string("22"), std::string("13"));
    ASSERT_EQ(run(shorter + Words{"-o", "a.exr", "--checkpoint", "c"}).status, 0);
    ASSERT_EQ(run({"resume", "c", "--passes", "22"}).status, 0);
    EXPECT_EQ(pixels("a.exr"), pixels("whole.exr"));

    ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--slices", "3", "--time", "0.7s", "-o", "b.exr",
                   "--stats", "b.json"})
                  .status,
              0);
    const nlohmann::json passes =
        nlohmann::json::parse(std::ifstream(folder / "b.json"))["integrator_statistics"]["passes_of_slices"];
    ASSERT_EQ(passes.size(), 3u);
    for (const char* slice : {"1", "2"}) EXPECT_NEAR(passes[slice].get<int>(), passes["0"].get<int>(), 8);
}

TEST_F(SlicesTest, RanksOfMpiMakeTheSameImage) {
    if (!haveMpi()) GTEST_SKIP() << "built without MPI, or mpirun is not there";
    for (const char* integrator : {"path", "vcm", "mcmc_vcm"}) {
        ASSERT_EQ(run(words(integrator) + Words{"-o", "one.exr", "--denoise"}).status, 0);
        for (int ranks = 1; ranks <= 3; ++ranks) {
            const Outcome outcome =
                runRanks(ranks, words(integrator) + Words{"-o", "ranks.exr", "--aov", "variance,denoised"});
            ASSERT_EQ(outcome.status, 0) << outcome.err;
            EXPECT_EQ(pixels("ranks.exr"), pixels("one.exr")) << integrator << " on " << ranks;
            EXPECT_EQ(readLayer(folder / "ranks.exr", "denoised").pixels,
                      readLayer(folder / "one.exr", "denoised").pixels)
                << integrator << " on " << ranks;
            fs::remove(folder / "ranks.exr");
        }
    }
}

/// Far brighter than single precision likes: rendered at ordinary brightness, and scaled in the end.
TEST_F(SlicesTest, RanksOfMpiKnowTheBrightnessOfTheScene) {
    if (!haveMpi()) GTEST_SKIP() << "built without MPI, or mpirun is not there";
    std::string scene = kTinyScene;
    scene.replace(scene.find("10, 9, 8"), 8, "1e24, 9e23, 8e23");
    write("scene.xml", scene);
    ASSERT_EQ(run(words("path") + Words{"-o", "one.exr"}).status, 0);
    const Outcome outcome = runRanks(2, words("path") + Words{"-o", "ranks.exr"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(pixels("ranks.exr"), pixels("one.exr"));
}

TEST_F(SlicesTest, ARankThatDiesEndsTheJobAndAnotherNumberOfRanksGoesOn) {
    if (!haveMpi()) GTEST_SKIP() << "built without MPI, or mpirun is not there";
    const Words longer{"render",   "scene.xml", "-i",       "mcmc_vcm", "--resolution", "24x18",
                       "--passes", "600",       "--slices", "8",        "--threads",    "1"};
    ASSERT_EQ(run(longer + Words{"-o", "whole.exr"}).status, 0);
    const Words saving{"-o", "a.exr", "--checkpoint", "c", "--checkpoint-every", "0.05s"};
    Command job(folder, longer + saving, mpirun(3));
    ASSERT_TRUE(waitFor("c"));
    std::ifstream children(fmt::format("/proc/{0}/task/{0}/children", job.pid()));
    pid_t rank = 0;
    while (children >> rank) {
    }
    ASSERT_GT(rank, 0);
    ASSERT_EQ(::kill(rank, SIGKILL), 0);  // the last one
    const Outcome dead = job.wait();
    EXPECT_NE(dead.status, 0);
    EXPECT_THAT(dead.err + dead.out, HasSubstr("exited on signal 9"));
    ASSERT_FALSE(fs::exists(folder / "a.exr"));
    const Outcome outcome = runRanks(2, {"resume", "c", "--threads", "1"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(pixels("a.exr"), pixels("whole.exr"));
}

TEST_F(SlicesTest, AProgramWithoutMpiSaysSoUnderALauncher) {
    if (METROLUX_TEST_MPI) GTEST_SKIP() << "built with MPI; -DMETROLUX_MPI=OFF builds without";
    for (const char* variable : {"OMPI_COMM_WORLD_SIZE=2", "PMI_SIZE=2"}) {
        const Outcome outcome =
            Command(folder, words("path") + Words{"-o", "a.exr"}, {"env", variable}).wait();
        EXPECT_EQ(outcome.status, 2) << variable;
        EXPECT_THAT(outcome.err, HasSubstr("one of 2 processes of MPI, but this program was built without"));
        EXPECT_FALSE(fs::exists(folder / "a.exr"));
    }
    // Slices of one process need none.
    EXPECT_EQ(run(words("path") + Words{"-o", "a.exr"}).status, 0);
}

TEST_F(SlicesTest, RanksNeedSlices) {
    if (!haveMpi()) GTEST_SKIP() << "built without MPI, or mpirun is not there";
    const Outcome outcome = runRanks(2, {"render", "scene.xml", "--passes", "4"});
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("give --slices S"));
}

}  // namespace
}  // namespace metrolux::core::cli
