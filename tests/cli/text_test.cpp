/// Names and texts that somebody else has chosen: whatever they are, they are rendered, and shown as nothing
/// but text.

#include "base/printable.h"
#include "command.h"
#include "image/image_io.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <sstream>

namespace metrolux::core::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

class TextTest : public CliTest {
  protected:
    static std::vector<std::string> linesOf(const std::string& text) {
        std::vector<std::string> lines;
        std::istringstream stream(text);
        for (std::string line; std::getline(stream, line);) lines.push_back(line);
        return lines;
    }
    /// Nothing but text, and each line begins as one of the program's own.
    static void expectHarmless(const Outcome& outcome) {
        for (const std::string& text : {outcome.out, outcome.err}) EXPECT_EQ(printableLines(text), text);
        for (const std::string& line : linesOf(outcome.err))
            EXPECT_FALSE(line.starts_with("[error] forged") || line.starts_with("forged")) << line;
    }
};

TEST_F(TextTest, NamesThatAreNotUtf8AreRenderedSavedAndResumed) {
    const std::string bad = "sc\xff\xfe\nne";
    write(bad + ".xml", kTinyScene);
    const auto render = [&](const std::string& image, const char* passes) {
        return Words{"render", bad + ".xml", "-i", "mcmc_vcm", "--passes", passes, "-o", image};
    };
    ASSERT_EQ(run(render("expected.exr", "4")).status, 0);
    const std::string image = "im\xffge.exr", checkpoint =
                                                  "ch\xff"
                                                  "ck";
    const Outcome first = run(render(image, "2") + Words{"--checkpoint", checkpoint, "--stats", "s\xff.json",
                                                         "--progress", "json"});
    ASSERT_EQ(first.status, 0) << first.err;
    expectHarmless(first);
    for (const std::string& line : linesOf(first.out)) EXPECT_TRUE(nlohmann::json::accept(line)) << line;
    const nlohmann::json stats = nlohmann::json::parse(std::ifstream(folder / "s\xff.json"));
    EXPECT_EQ(stats["scene"], "sc\\xff\\xfe\nne.xml") << "in JSON a line feed is a character like any other";
    const Outcome second = run({"resume", checkpoint, "--passes", "4"});
    ASSERT_EQ(second.status, 0) << second.err;
    expectHarmless(second);
    EXPECT_EQ(pixels(image), pixels("expected.exr"));
    // Another scene of another name that is none either is another scene.
    write("sc\xfe.xml", kTinyScene);
    std::filesystem::remove(folder / (bad + ".xml"));
    const Outcome gone = run({"resume", checkpoint, "--passes", "6"});
    EXPECT_EQ(gone.status, 2);
    expectHarmless(gone);
}

TEST_F(TextTest, PartsOfNamesThatAreNotUtf8AreMerged) {
    write("\xff.xml", kTinyScene);
    for (const char* part : {"0", "1"})
        ASSERT_EQ(run({"render", "\xff.xml", "-i", "path", "--passes", "2", "--slices", "2", "--only-slices",
                       part, "--checkpoint", std::string("\xfe") + part})
                      .status,
                  0);
    const Outcome merged = run({"merge",
                                "\xfe"
                                "0",
                                "\xfe"
                                "1",
                                "-o", "\xff.exr", "--stats", "s.json"});
    EXPECT_EQ(merged.status, 0) << merged.err;
    expectHarmless(merged);
    EXPECT_TRUE(nlohmann::json::accept(std::ifstream(folder / "s.json")));
}

TEST_F(TextTest, TextsOfASceneCannotForgeLines) {
    const std::string forged = "x&#10;[error] forged&#27;[2J&#155;31m";
    const std::vector<std::string> scenes{
        "<shape type=\"" + forged + "\"/>",
        "<shape type=\"sphere\"><float name=\"" + forged + "\" value=\"1\"/></shape>",
        "<shape type=\"sphere\"><float name=\"radius\" value=\"" + forged + "\"/></shape>",
        "<shape type=\"obj\"><string name=\"filename\" value=\"" + forged + "\"/></shape>",
        "<integrator type=\"" + forged + "\"/>",
        "<include filename=\"" + forged + "\"/>",
        "<ref id=\"" + forged + "\"/>",
        "<"
        "x:y"
        "/>",
    };
    for (const std::string& content : scenes) {
        write("forged.xml",
              "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\"/>" +
                  content + "</scene>");
        for (const Words& words :
             {Words{"render", "forged.xml", "--passes", "1", "-i", "scene"},
              Words{"render", "forged.xml", "--passes", "1", "--lenient"}, Words{"info", "forged.xml"},
              Words{"info", "forged.xml", "--lenient", "--json"}}) {
            SCOPED_TRACE(content + " " + testing::PrintToString(words));
            expectHarmless(run(words));
        }
    }
    write("a\n[error] forged\x1b[2J.xml", kTinyScene);
    expectHarmless(run({"render", "a\n[error] forged\x1b[2J.xml", "--passes", "1"}));
    expectHarmless(run({"render", "scene.xml", "--passes", "1", "--res\x1b[2J"}));
    expectHarmless(run({"\n[error] forged"}));
}

/// A scene may name any file of the machine that renders it. What is in it is not told.
TEST_F(TextTest, AFileThatIsNotWhatItShouldBeIsNotQuoted) {
    const std::string secret = "root hunter2 9Zq8\nv swordfish\nlogin: hunter2\n";
    write("secret", secret);
    for (const char* extension : {"xml", "obj", "ply", "serialized", "spd", "png", "exr"})
        write(std::string("secret.") + extension, secret);
    const auto scene = [&](const std::string& content) {
        write("s.xml", "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><emitter type=\"constant\"/>" +
                           content + "</scene>");
        return Words{"render", "s.xml", "--passes", "1"};
    };
    const auto shape = [&](const std::string& type) {
        return scene("<shape type=\"" + type + "\"><string name=\"filename\" value=\"secret." + type +
                     "\"/></shape>");
    };
    for (const Words& words :
         {shape("obj"), shape("ply"), shape("serialized"), scene("<include filename=\"secret.xml\"/>"),
          scene("<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">"
                "<string name=\"filename\" value=\"secret.png\"/></texture></bsdf>"),
          scene("<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">"
                "<string name=\"filename\" value=\"secret.exr\"/></texture></bsdf>"),
          scene("<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" filename=\"secret.spd\"/></bsdf>"),
          Words{"render", "secret"}, Words{"info", "secret"}, Words{"resume", "secret"},
          Words{"merge", "secret"}, Words{"compare", "secret.exr", "secret.png"}}) {
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.status, 2) << testing::PrintToString(words);
        for (const char* word : {"hunter2", "9Zq8", "login", "swordfish"})
            EXPECT_THAT(outcome.out + outcome.err, Not(HasSubstr(word))) << testing::PrintToString(words);
    }
}

TEST_F(TextTest, ProgressForProgramsIsAnObjectALine) {
    const Outcome outcome = run({"render", "scene.xml", "-i", "mcmc_vcm", "--time", "0.6s", "-o", "a.exr",
                                 "-o", "a.png", "--progress", "json"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::vector<nlohmann::json> events;
    for (const std::string& line : linesOf(outcome.out)) events.push_back(nlohmann::json::parse(line));
    ASSERT_GE(events.size(), 4u);
    EXPECT_EQ(events.front()["event"], "begin");
    EXPECT_EQ(events.front()["scene"], "scene.xml");
    EXPECT_EQ(events.front()["width"], 24);
    EXPECT_EQ(events.front()["integrator"], "mcmc_vcm");
    double seconds = 0;
    for (size_t i = 1; i + 1 < events.size(); ++i) {
        EXPECT_EQ(events[i]["event"], "pass");
        EXPECT_GT(events[i]["passes"], 0);
        EXPECT_GT(events[i]["seconds"], seconds);
        seconds = events[i]["seconds"];
        EXPECT_TRUE(events[i].contains("seconds_remaining") && events[i].contains("relative_error"));
        EXPECT_TRUE(events[i]["rays_per_second"].is_number());
    }
    EXPECT_EQ(events.back()["event"], "end");
    EXPECT_EQ(events.back()["reason"], "time");
    EXPECT_EQ(events.back()["status"], 0);
    EXPECT_EQ(events.back()["images"], (nlohmann::json{"a.exr", "a.png"}));
    EXPECT_THAT(outcome.err, Not(HasSubstr("pass 1")));

    const Outcome failed = run({"render", "none.xml", "--progress", "json"});
    EXPECT_EQ(failed.status, 2);
    const nlohmann::json error = nlohmann::json::parse(failed.out);
    EXPECT_EQ(error["event"], "error");
    EXPECT_EQ(error["status"], 2);
    EXPECT_THAT(std::string(error["text"]), HasSubstr("none.xml"));
}

TEST_F(TextTest, ProgressForPeopleIsPlainUnlessTheyAskForMore) {
    const auto messages = [&](const Words& more) {
        return run(Words{"render", "scene.xml", "-i", "mcmc_vcm", "--passes", "4"} + more).err;
    };
    EXPECT_THAT(messages({}), HasSubstr("pass 1"));
    EXPECT_THAT(messages({}), Not(HasSubstr("visible")));
    EXPECT_THAT(messages({}), Not(HasSubstr("acceptance")));
    EXPECT_THAT(messages({"-v"}), HasSubstr("no visible light subpath yet"));
    EXPECT_THAT(messages({"--progress", "none"}), Not(HasSubstr("pass 1")));
    EXPECT_THAT(messages({"--progress", "none"}), HasSubstr("wrote"));
}

}  // namespace
}  // namespace metrolux::core::cli
