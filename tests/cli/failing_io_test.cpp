/// Every call of the operating system that writes an output fails in turn, for each kind of output: the old
/// files stay whole, and the exit status says what happened. failing_io.cpp makes the calls fail.

#include "command.h"
#include "image/image_io.h"
#include "paths.h"
#include "render/checkpoint.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <map>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using testing::AnyOf;
using testing::Eq;
using testing::HasSubstr;

/// A kind of output, and the command that makes it. Outputs are in the folder `out`.
struct Kind {
    std::string name;
    Words words;
    size_t files;  ///< how many
    std::vector<int> errors{ENOSPC, EIO, EFBIG, EINTR};
};
void PrintTo(const Kind& kind, std::ostream* stream) { *stream << kind.name; }

std::string contentOf(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

class FailingIo : public CliTest, public testing::WithParamInterface<Kind> {
  protected:
    FailingIo() {
        // Inputs of the commands, and old files that a failure must not touch: of another seed.
        require(run({"render", "scene.xml", "-i", "path", "--passes", "1", "--seed", "5", "-o", "a.exr"}));
        require(run({"render", "scene.xml", "-i", "path", "--passes", "1", "--seed", "6", "-o", "b.exr"}));
        for (const char* part : {"0", "1"})
            require(run({"render", "scene.xml", "-i", "path", "--passes", "2", "--slices", "2",
                         "--only-slices", part, "--checkpoint", std::string("part") + part}));
        fs::create_directory(folder / "out");
        require(run(GetParam().words));
        for (const auto& entry : fs::recursive_directory_iterator(folder / "out"))
            if (entry.is_regular_file())
                fresh_[fs::relative(entry.path(), folder / "out")] = contentOf(entry.path());
    }

    void require(const Outcome& outcome) const {
        if (outcome.status != 0) throw std::runtime_error(outcome.err);
    }

    Outcome runFailing(int call, int error, bool stays = false) const {
        Words environment{"env",
                          "LD_PRELOAD=" + std::string(METROLUX_BINARY_DIR) + "/tests/libfailing_io.so",
                          "ASAN_OPTIONS=verify_asan_link_order=0:detect_leaks=0",
                          "FAILING_IO_FOLDER=" + fs::canonical(folder / "out").string(),
                          "FAILING_IO_CALL=" + std::to_string(call),
                          "FAILING_IO_ERRNO=" + std::to_string(error),
                          "FAILING_IO_LOG=" + (folder / "log").string()};
        if (stays) environment.push_back("FAILING_IO_STAYS=1");
        fs::remove(folder / "log");
        return Command(folder, GetParam().words, environment).wait();
    }

    std::vector<std::string> log() const {
        std::vector<std::string> lines;
        std::ifstream stream(folder / "log");
        for (std::string line; std::getline(stream, line);) lines.push_back(line);
        return lines;
    }

    /// Old files that are whole, and nothing else.
    void restore() const {
        fs::remove_all(folder / "out");
        fs::create_directory(folder / "out");
        for (const auto& [file, content] : fresh_) {
            fs::create_directories((folder / "out" / file).parent_path());
            std::ofstream(folder / "out" / file, std::ios::binary) << content;
        }
    }

    /// Reads the whole file.
    void expectWhole(const std::string& file) const {
        const fs::path path = folder / "out" / file;
        const std::string extension = path.extension();
        if (extension == ".exr" || extension == ".png") {
            EXPECT_NO_THROW(readImage(path, false)) << file;
        } else if (extension == ".json") {
            EXPECT_NO_THROW(nlohmann::json::parse(contentOf(path))) << file;
        } else if (file == "c" || file == "c.1") {
            EXPECT_NO_THROW(readCheckpoint(path, METROLUX_TEST_VERSION)) << file;
        } else {
            // Tables end with a line end and pages with a tag, however long they are.
            const std::string content = contentOf(path);
            ASSERT_FALSE(content.empty()) << file;
            EXPECT_THAT(content.back(), AnyOf('\n', '>')) << file;
        }
    }

    std::vector<std::string> leftovers() const {
        std::vector<std::string> result;
        for (const auto& entry : fs::recursive_directory_iterator(folder / "out"))
            if (entry.path().extension() == ".tmp") result.push_back(entry.path().filename());
        return result;
    }

    bool isUntouched(const std::string& file) const {
        return contentOf(folder / "out" / file) == fresh_.at(file);
    }

    void expectNothingLost(const Outcome& outcome, int error) const {
        for (const auto& [file, content] : fresh_) expectWhole(file);
        EXPECT_THAT(outcome.status, AnyOf(Eq(0), Eq(2), Eq(4))) << outcome.err;
        if (outcome.status == 0) return;
        EXPECT_THAT(outcome.err, HasSubstr(std::strerror(error)));
        // Found before anything was rendered.
        for (const auto& [file, content] : fresh_)
            EXPECT_TRUE(outcome.status != 2 || isUntouched(file)) << file;
    }

    std::map<std::string, std::string> fresh_;  ///< contents of the outputs by name
};

TEST_P(FailingIo, EveryCallCanFailAndOldFilesStayWhole) {
    restore();
    ASSERT_EQ(fresh_.size(), GetParam().files);
    require(runFailing(0, 0));
    const std::vector<std::string> calls = log();
    ASSERT_GE(calls.size(), 8u) << "the library was not loaded";
    std::map<int, int> statuses;
    for (size_t call = 1; call <= calls.size(); ++call)
        for (const int error : GetParam().errors) {
            SCOPED_TRACE(fmt::format("{}: {}", calls[call - 1], std::strerror(error)));
            restore();
            const Outcome outcome = runFailing(static_cast<int>(call), error);
            ++statuses[outcome.status];
            expectNothingLost(outcome, error);
            // Interrupted calls are made again. (unlink and remove know no EINTR.)
            const bool removes = calls[call - 1].find("remove") != std::string::npos ||
                                 calls[call - 1].find("unlink") != std::string::npos;
            if (error == EINTR && !removes) {
                EXPECT_EQ(outcome.status, 0) << outcome.err;
            }
            if (!removes) {
                EXPECT_TRUE(leftovers().empty()) << leftovers().front();
            }
            // What carries the data may not fail in silence; a checkpoint that is not the last is tried
            // again.
            const bool carries = calls[call - 1].find(" write ") != std::string::npos ||
                                 calls[call - 1].find(" rename ") != std::string::npos ||
                                 (calls[call - 1].find(" fsync ") != std::string::npos &&
                                  calls[call - 1].find(".tmp") != std::string::npos);
            // A lock carries none: only the name of its holder.
            const bool locks = calls[call - 1].find(".lock") != std::string::npos;
            if (error != EINTR && carries && !locks) {
                EXPECT_THAT(outcome.err, HasSubstr(std::strerror(error)));
            }
        }
    for (const auto& [status, count] : statuses) RecordProperty(fmt::format("status_{}", status), count);
    fmt::print("{}: {} calls, {} errors each; runs by status:", GetParam().name, calls.size(),
               GetParam().errors.size());
    for (const auto& [status, count] : statuses) fmt::print(" {}: {}", status, count);
    fmt::print("\n");
}

/// A disk that is full from some call on, and stays full.
TEST_P(FailingIo, AFullDiskThatStaysFullLosesNothing) {
    restore();
    require(runFailing(0, 0));
    const std::vector<std::string> calls = log();
    for (size_t call = 1; call <= calls.size(); ++call) {
        if (calls[call - 1].find(" write ") == std::string::npos) continue;
        SCOPED_TRACE(calls[call - 1]);
        restore();
        const Outcome outcome = runFailing(static_cast<int>(call), ENOSPC, true);
        EXPECT_EQ(outcome.status, 4) << outcome.err;
        expectNothingLost(outcome, ENOSPC);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FailingIo,
    testing::Values(Kind{"images",
                         {"render", "scene.xml", "-i", "path", "--passes", "1", "-o", "out/a.exr", "-o",
                          "out/a.png", "--stats", "out/a.json"},
                         3},
                    Kind{"checkpoint",
                         {"render", "scene.xml", "-i", "path", "--passes", "2", "-o", "a2.exr",
                          "--checkpoint", "out/c", "--checkpoint-every", "0.000001s"},
                         2},
                    Kind{"merge", {"merge", "part0", "part1", "-o", "out/a.png"}, 1},
                    Kind{"heatmap", {"compare", "a.exr", "b.exr", "--heatmap", "out/h.png"}, 1},
                    Kind{"study",
                         {"study", "scene.xml", "--integrators", "path", "--passes", "1", "--seeds", "1",
                          "--ref", "a.exr", "-o", "out"},
                         8,
                         {ENOSPC, EINTR}}),
    [](const auto& i) { return i.param.name; });

}  // namespace
}  // namespace metrolux::core::cli
