#include "command.h"
#include "image/image_io.h"
#include "paths.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdlib>
#include <fstream>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

nlohmann::json readJson(const fs::path& file) { return nlohmann::json::parse(std::ifstream(file)); }

class StudyTest : public CliTest {
  protected:
    /// A reference of the tiny scene at 32x24.
    StudyTest() {
        run({"render", "scene.xml", "--resolution", "32x24", "--passes", "8", "-i", "bdpt", "-o", "ref.exr"});
    }
    std::vector<std::string> study(std::vector<std::string> more) const {
        std::vector<std::string> words{"study", "scene.xml", "--resolution", "32x24"};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    /// The one folder in `study`.
    fs::path result() const { return fs::directory_iterator(folder / "study")->path(); }
};

TEST_F(StudyTest, WritesEverything) {
    const Outcome outcome = run(study({"--integrators", "path,mcmc_vcm:kernel=adaptive", "--passes", "2",
                                       "--seeds", "2", "--ref", "ref.exr"}));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("| mcmc_vcm:kernel=adaptive |"));
    const nlohmann::json json = readJson(result() / "study.json");
    EXPECT_EQ(json["format"], "metrolux-study");
    EXPECT_EQ(json["scene"]["options"]["resolution"], "32x24");
    EXPECT_EQ(json["command"][1], "study");
    EXPECT_EQ(json["entrants"][1]["options"][0], "--kernel=adaptive");
    for (const auto& entrant : json["entrants"]) {
        EXPECT_EQ(entrant["status"], "done");
        for (const auto& entry : entrant["runs"]) {
            EXPECT_EQ(entry["points"].back()["passes"], 2);
            EXPECT_TRUE(fs::exists(result() / entry["exr"].get<std::string>()));
            EXPECT_TRUE(fs::exists(result() / entry["png"].get<std::string>()));
        }
    }
    for (const char* file : {"curves.csv", "table.md", "reference.exr", "reference.png"})
        EXPECT_TRUE(fs::exists(result() / file)) << file;

    // The same seed and passes: the image of `metrolux render`.
    ASSERT_EQ(run({"render", "scene.xml", "--resolution", "32x24", "-i", "path", "--passes", "2", "--seed",
                   "2", "-o", "path.exr"})
                  .status,
              0);
    EXPECT_EQ(readImage(folder / "path.exr", false).pixels,
              readImage(result() / "path-seed2.exr", false).pixels);
}

TEST_F(StudyTest, RendersAReferenceAtEqualTime) {
    const Outcome outcome =
        run(study({"--integrators", "path", "--time", "0.2s", "--seeds", "1", "--ref-time", "0.4s"}));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json json = readJson(result() / "study.json");
    EXPECT_EQ(json["reference"]["source"], "rendered");
    EXPECT_EQ(json["reference"]["integrator"], "mcmc_vcm");
    EXPECT_GT(json["reference"]["noise"]["rel_mse"], 0);
    EXPECT_EQ(json["plan"]["limit"], "seconds");
}

TEST_F(StudyTest, ErrorsSayWhatIsWrong) {
    ASSERT_EQ(run({"render", "scene.xml", "--passes", "1", "-o", "small.exr"}).status, 0);
    const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
        {{"--integrators", "path"}, "--ref"},
        {{"--ref", "ref.exr"}, "--integrators"},
        {{"--integrators", "path", "--ref", "ref.exr", "--ref-time", "5s"}, "exclude"},
        {{"--integrators", "path", "--ref", "ref.exr", "--ref", "ref.exr"}, "2 times for 1 scenes"},
        {{"--integrators", "path", "--ref", "absent.exr"}, "absent.exr"},
        {{"--integrators", "path", "--ref", "small.exr"}, "24x16"},
        {{"--integrators", "pth", "--ref", "ref.exr"}, "did you mean 'path'"},
        {{"--integrators", "path,path", "--ref", "ref.exr"}, "named twice"},
        {{"--integrators", "path:kernl=kelemen", "--ref", "ref.exr"}, "kernl"},
        {{"--integrators", "path:kernel=x", "--ref", "ref.exr"}, "kernel"},
        {{"--integrators", "path:seed=3", "--ref", "ref.exr"}, "seed"},
        {{"--integrators", "path:", "--ref", "ref.exr"}, "missing after ':'"},
        {{"--integrators", "path", "--ref", "ref.exr", "--time", "1s", "--passes", "2"}, "exclude"},
        {{"--integrators", "path", "--ref", "ref.exr", "--seeds", "0"}, "--seeds"},
        {{"--integrators", "path", "--ref-time", "soon"}, "soon"},
        {{"--integrators", "path", "--ref-time", "1s", "--ref-integrator", "pat"}, "'path'"},
        {{"--integrators", "path", "--ref", "ref.exr", "-o", "/proc/study"}, "/proc/study"},
    };
    for (const auto& [more, message] : cases) {
        const Outcome outcome = run(study(more));
        EXPECT_EQ(outcome.status, 2) << testing::PrintToString(more);
        EXPECT_THAT(outcome.err, HasSubstr(message)) << testing::PrintToString(more);
    }
    EXPECT_EQ(run({"study", "absent.xml", "--integrators", "path", "--ref", "ref.exr"}).status, 2);
}

TEST_F(StudyTest, InterruptedWritesWhatIsThere) {
    Command command(folder, study({"--integrators", "path,bdpt", "--passes", "3", "--seeds", "1000", "--ref",
                                   "ref.exr"}));
    ASSERT_TRUE(waitFor("study"));
    ASSERT_TRUE(
        waitFor(fs::relative(folder / "study" / result().filename() / "study.json", folder).string()));
    command.signal(SIGINT);
    const Outcome outcome = command.wait();
    EXPECT_EQ(outcome.status, 3) << outcome.err;
    const nlohmann::json json = readJson(result() / "study.json");
    EXPECT_EQ(json["interrupted"], true);
    EXPECT_EQ(json["entrants"][0]["status"], "incomplete");
    EXPECT_GE(json["entrants"][0]["summary"]["runs"], 1);
}

/// The page of the repository is the one that its sources make: `make viewer` makes it.
TEST_F(StudyTest, PageIsMadeOfItsSources) {
    const auto contentOf = [](const fs::path& file) {
        std::ostringstream text;
        text << std::ifstream(file, std::ios::binary).rdbuf();
        return text.str();
    };
    const fs::path bundled = fs::path(METROLUX_BINARY_DIR) / "web/viewer.html";
    if (!fs::exists(bundled)) GTEST_SKIP() << "built without node and npm";
    EXPECT_TRUE(contentOf(bundled) == contentOf(fs::path(METROLUX_SOURCE_DIR) / "web/viewer.html"));
}

/// The page in headless Chromium: web/test/page.mjs opens it, operates it and prints what it saw.
TEST_F(StudyTest, PageWorksInABrowser) {
    const fs::path web = fs::path(METROLUX_BINARY_DIR) / "web";
    if (!fs::exists(web / "viewer.html")) GTEST_SKIP() << "built without node and npm";
    if (std::system("command -v chromium >/dev/null") != 0) GTEST_SKIP() << "chromium is not installed";
    ASSERT_EQ(
        run(study({"--integrators", "path,vcm", "--passes", "4", "--seeds", "2", "--ref", "ref.exr"})).status,
        0);
    const std::string script = "cd '" + web.string() + "' && node test/page.mjs '" +
                               (result() / "index.html").string() + "' '" + (folder / "page.json").string() +
                               "' > '" + (folder / "page.log").string() + "' 2>&1";
    const int status = std::system(script.c_str());
    std::ostringstream log;
    log << std::ifstream(folder / "page.log").rdbuf();
    ASSERT_EQ(status, 0) << log.str();
    const nlohmann::json seen = readJson(folder / "page.json");
    EXPECT_EQ(seen["pixels"].size(), 9u) << "three images at three places";
    for (const auto& pixel : seen["pixels"]) {
        const std::string name = pixel["image"];
        const ImageData exr =
            readImage(result() / (name == "reference" ? "reference.exr" : name + "-seed1.exr"), false);
        for (int c = 0; c < 3; ++c)
            EXPECT_EQ(std::strtof(pixel["rgb"][static_cast<size_t>(c)].get<std::string>().c_str(), nullptr),
                      exr.at(pixel["x"], pixel["y"])[c])
                << pixel;
    }
}

}  // namespace
}  // namespace metrolux::core::cli
