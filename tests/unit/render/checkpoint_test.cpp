/// What a checkpoint may hold, beyond its checksum: whoever makes a file makes the checksum too.
#include "render/checkpoint.h"

#include "base/error.h"
#include "base/state_archive.h"
#include "render/merge.h"
#include "support/temporary_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace metrolux::core {
namespace {

using testing::HasSubstr;

constexpr const char* kVersion = "1.2.3";
constexpr FilmWindow kWindow{6, 4, 1, 1, 3, 2};

nlohmann::json identityOf(uint32_t slices) {
    return {{"scene", {{"name", "a.xml"}}},
            {"algorithm", {{"integrator", "path"}, {"seed", 7}}},
            {kSliceCountKey, slices}};
}

Film makeFilm() { return Film(kWindow, ReconstructionFilter(ReconstructionFilter::Kind::Box, {})); }

std::string stateOf(const Film& film) {
    StateWriter writer;
    film.saveState(writer);
    return writer.take();
}

/// Two passes of slice 1 of 4.
Checkpoint good() {
    Film film = makeFilm();
    for (const float value : {1.0f, 3.0f}) {
        film.addEye(2, Rgb(value));
        film.endPass();
    }
    Checkpoint c;
    c.version = kVersion;
    c.command = {"metrolux", "render", "a.xml"};
    c.folder = "/somewhere";
    c.outputs = {"a.exr"};
    c.limits = {60, 8, 0.01};
    c.identity = identityOf(4).dump();
    c.seconds = 1.5;
    c.rays = {10, 20, 0.5};
    c.nonFinite = {1, 2, 3, 4, 5};
    c.window = kWindow;
    c.film = stateOf(film);
    c.slices = {{1, 2, "state"}};
    return c;
}

Checkpoint writtenAndRead(const Checkpoint& checkpoint) {
    const test::TemporaryFolder folder;
    writeCheckpoint(folder.path() / "c", checkpoint);
    return readCheckpoint(folder.path() / "c", kVersion);
}

TEST(CheckpointFile, HoldsWhatWasWritten) {
    const Checkpoint expected = good(), read = writtenAndRead(expected);
    EXPECT_EQ(read.command, expected.command);
    EXPECT_EQ(read.folder, expected.folder);
    EXPECT_EQ(read.outputs, expected.outputs);
    EXPECT_EQ(read.limits.seconds, 60);
    EXPECT_EQ(read.limits.passes, 8u);
    EXPECT_EQ(read.limits.relativeError, 0.01);
    EXPECT_EQ(read.identity, expected.identity);
    EXPECT_EQ(read.seconds, 1.5);
    EXPECT_EQ(read.rays.intersectRays, 10u);
    EXPECT_EQ(read.nonFinite, expected.nonFinite);
    EXPECT_EQ(read.rays.shadowRays, 20u);
    EXPECT_EQ(read.window.x, 1);
    EXPECT_EQ(read.window.width, 3);
    EXPECT_EQ(read.film, expected.film);
    ASSERT_EQ(read.slices.size(), 1u);
    EXPECT_EQ(read.slices[0].index, 1u);
    EXPECT_EQ(read.slices[0].passes, 2u);
    EXPECT_EQ(read.slices[0].integrator, "state");
}

struct BadContent {
    const char* name;
    std::function<void(Checkpoint&)> change;
    const char* expected;  ///< of the message
};

template <class Change>
auto inIdentity(Change change) {
    return [change](Checkpoint& c) {
        nlohmann::json identity = identityOf(4);
        change(identity);
        c.identity = identity.dump();
    };
}

const double kNan = std::numeric_limits<double>::quiet_NaN();
const std::vector<BadContent> kBadContents{
    {"NoJson", [](Checkpoint& c) { c.identity = "{\"scene\""; }, "an identity in JSON"},
    // Deep enough for a stack to overflow where it is compared.
    {"Deep", [](Checkpoint& c) { c.identity = std::string(200000, '[') + std::string(200000, ']'); },
     "an identity of fewer levels"},
    {"OtherJson", [](Checkpoint& c) { c.identity = "[1]"; }, "the scene's name"},
    {"NoName", inIdentity([](nlohmann::json& i) { i["scene"].erase("name"); }), "the scene's name"},
    {"NameIsANumber", inIdentity([](nlohmann::json& i) { i["scene"]["name"] = 1; }), "the scene's name"},
    {"NoIntegrator", inIdentity([](nlohmann::json& i) { i["algorithm"].erase("integrator"); }),
     "the integrator's name"},
    {"NoSeed", inIdentity([](nlohmann::json& i) { i["algorithm"].erase("seed"); }), "a seed"},
    {"NoSlices", inIdentity([](nlohmann::json& i) { i[kSliceCountKey] = 0; }), "a number of slices"},
    {"NegativeSlices", inIdentity([](nlohmann::json& i) { i[kSliceCountKey] = -1; }), "a number of slices"},
    {"TooManySlices", inIdentity([](nlohmann::json& i) { i[kSliceCountKey] = kMostSlices + 1; }),
     "a number of slices"},
    {"WindowBeyondTheImage", [](Checkpoint& c) { c.window.x = 4; }, "a window inside of the image"},
    {"WindowFarAway", [](Checkpoint& c) { c.window.x = std::numeric_limits<int>::max(); },
     "a window inside of the image"},
    {"EmptyWindow", [](Checkpoint& c) { c.window.height = 0; }, "a window inside of the image"},
    // Would take 47 GB.
    {"WindowWithoutBytes", [](Checkpoint& c) { c.window = {1 << 14, 1 << 14, 0, 0, 1 << 14, 1 << 14}; },
     "the sums of all pixels"},
    {"SecondsAreNoNumber", [](Checkpoint& c) { c.seconds = kNan; }, "times and limits"},
    {"NegativeLimit", [](Checkpoint& c) { c.limits.seconds = -1; }, "times and limits"},
};

TEST(CheckpointFile, ContentsThatNoRenderingHasAreRefused) {
    for (const BadContent& bad : kBadContents) {
        Checkpoint checkpoint = good();
        bad.change(checkpoint);
        try {
            writtenAndRead(checkpoint);
            ADD_FAILURE() << bad.name << " was read";
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), HasSubstr("/c' is damaged: saved state: expected")) << bad.name;
            EXPECT_THAT(error.what(), HasSubstr(bad.expected)) << bad.name;
        }
    }
}

TEST(Merge, NamesThePartWhoseFilmIsDamaged) {
    Checkpoint part = good();
    part.film.pop_back();
    PartMerger merger;
    try {
        merger.add("part7", part);
        FAIL() << "was merged";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("'part7' is damaged: saved state: found"));
    }
}

/// Sums that no rendering reaches must not be undefined behavior (the sanitizer sees it).
TEST(Merge, SumsOfAnyBitsAreDefined) {
    Checkpoint part = good();
    // Passes, a flag and a size come first; all sums are made the largest there is.
    constexpr size_t kSumsBegin = 4 + 1 + 8;
    for (size_t pixel = 0; pixel < 6; ++pixel)
        for (size_t sum = 0; sum < sizeof(PixelSum) / 16; ++sum) {
            std::string largest(15, '\xff');
            part.film.replace(kSumsBegin + pixel * sizeof(PixelSum) + 16 * sum, 16, largest + '\x7f');
        }
    PartMerger merger;
    merger.add("a", part);
    part.slices[0].index = 2;
    merger.add("b", part);
    EXPECT_EQ(merger.film().passes(), 4u);
    EXPECT_EQ(merger.nonFinite(), (TechniqueCounts{2, 4, 6, 8, 10}));
    for (const float value : merger.film().image()) EXPECT_LT(std::abs(value), 1) << "wrapped to -2 units";
}

/// Linux stamps a file by a fine clock once it has been looked at, and by a coarse one otherwise.
TEST(FileClock, IsNotBeforeTheStampOfAFileThatWasWritten) {
    const test::TemporaryFolder folder;
    for (int i = 0; i < 1000; ++i) {
        const std::filesystem::path file = folder.write("a", std::to_string(i));
        ASSERT_LE(stampOf(file).modified, fileClock()) << "write " << i;
    }
}

}  // namespace
}  // namespace metrolux::core
