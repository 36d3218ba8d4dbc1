/// `metrolux view` and `render --serve` as programs.

#include "command.h"
#include "image/image_io.h"
#include "paths.h"
#include "support/fake_tev.h"
#include "support/http_client.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <thread>

namespace metrolux::core::cli {
namespace {

namespace fs = std::filesystem;
using core::test::HttpClient;
using testing::HasSubstr;

std::string textOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

class ViewTest : public CliTest {
  protected:
    ViewTest() {
        ::unsetenv("DISPLAY");
        ::unsetenv("WAYLAND_DISPLAY");
    }
    /// The address that the program has printed; 30 s at most.
    std::string url() const {
        for (int i = 0; i < 3000; ++i) {
            for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
                if (entry.path().extension() != ".err") continue;
                std::smatch match;
                const std::string text = textOf(entry.path());
                static const std::regex address(R"((http://\S+/\S*)\n)");
                if (std::regex_search(text, match, address)) return match[1];
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        ADD_FAILURE() << "no address was printed";
        return "http://127.0.0.1:1/";
    }
    static uint16_t portOf(const std::string& url) {
        return static_cast<uint16_t>(std::stoi(url.substr(url.find(':', 7) + 1)));
    }
    static std::string get(const std::string& url, const std::string& target) {
        HttpClient client(portOf(url));
        client.send(fmt::format("GET {} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n", target, portOf(url)));
        return client.receive(20000);
    }
    static nlohmann::json json(const std::string& response) {
        return nlohmann::json::parse(response.substr(response.find("\r\n\r\n") + 4));
    }
    /// Sends a command with the token of the page.
    static std::string post(const std::string& url, const std::string& body) {
        std::smatch match;
        const std::string page = get(url, "/");
        static const std::regex mark(R"re("metrolux-token" content="(\w+)")re");
        EXPECT_TRUE(std::regex_search(page, match, mark));
        HttpClient client(portOf(url));
        client.send(
            fmt::format("POST /command HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nX-Metrolux-Token: {}\r\n"
                        "Content-Length: {}\r\n\r\n{}",
                        portOf(url), match[1].str(), body.size(), body));
        return client.receive(20000);
    }
    static nlohmann::json waitForPhase(const std::string& url, const std::string& phase) {
        nlohmann::json state;
        for (int i = 0; i < 600; ++i) {
            state = json(get(url, "/state"));
            if (state["phase"] == phase) return state;
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        ADD_FAILURE() << "phase " << phase << " never came: " << state["phase"];
        return state;
    }
};

TEST_F(ViewTest, ShowsWhatRenderWrites) {
    Command view(folder, {"view", "scene.xml", "-i", "path", "--passes", "6", "--no-open", "-o", "a.exr"});
    const std::string page = url();
    EXPECT_THAT(page, testing::StartsWith("http://127.0.0.1:"));
    const nlohmann::json state = waitForPhase(page, "done");
    EXPECT_EQ(state["sides"][0]["passes"], 6);
    ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--passes", "6", "-o", "plain.exr"}).status, 0);
    const ImageData plain = readImage(folder / "plain.exr", false);
    for (const auto& [x, y] : {std::pair(0, 0), {11, 9}, {23, 15}}) {
        const std::string target = fmt::format("/pixel?x={}&y={}", x, y);
        const std::string response = get(page, target);
        for (int c = 0; c < 3; ++c)
            EXPECT_EQ(json(response)["values"][static_cast<size_t>(c)].get<float>(), plain.at(x, y)[c])
                << response;
    }
    EXPECT_THAT(get(page, "/frame?layer=color"), HasSubstr("X-Frame: {\"channels\":3"));
    EXPECT_THAT(get(page, "/pixel?x=24&y=0"), HasSubstr("400"));
    EXPECT_THAT(get(page, "/nothing"), HasSubstr("404"));
    view.signal(SIGTERM);
    const Outcome outcome = view.wait();
    EXPECT_EQ(outcome.status, 0) << outcome.err << "the limit was reached";
    EXPECT_EQ(pixels("a.exr").size(), plain.pixels.size());
    EXPECT_EQ(std::memcmp(pixels("a.exr").data(), plain.pixels.data(), plain.pixels.size() * sizeof(float)),
              0);
}

TEST_F(ViewTest, AnInterruptWritesTheImage) {
    Command view(folder, {"view", "scene.xml", "-i", "path", "--no-open", "-o", "a.exr"});
    const std::string page = url();
    while (json(get(page, "/state"))["sides"].empty() || json(get(page, "/state"))["sides"][0]["passes"] < 2)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_THAT(post(page, R"({"do":"pause"})"), HasSubstr("202"));
    waitForPhase(page, "paused");
    view.signal(SIGINT);
    EXPECT_EQ(view.wait().status, 3);
    EXPECT_TRUE(fs::exists(folder / "a.exr"));
}

TEST_F(ViewTest, SavesACheckpointThatResumeGoesOnFrom) {
    Command view(
        folder, {"view", "scene.xml", "-i", "path", "--passes", "3", "--no-open", "--port=0", "-o", "a.exr"});
    EXPECT_EQ(view.wait().status, 2) << "port 0 is none";
    Command again(folder, {"view", "scene.xml", "-i", "path", "--passes", "3", "--no-open", "-o", "a.exr"});
    const std::string page = url();
    waitForPhase(page, "done");
    EXPECT_THAT(post(page, R"({"do":"save"})"), HasSubstr("202"));
    ASSERT_TRUE(waitFor("a.checkpoint"));
    again.signal(SIGTERM);
    EXPECT_EQ(again.wait().status, 0);
    const Outcome resumed = run({"resume", "a.checkpoint", "--passes", "5", "-o", "b.exr"});
    EXPECT_EQ(resumed.status, 0) << resumed.err;
    ASSERT_EQ(run({"render", "scene.xml", "-i", "path", "--passes", "5", "-o", "plain.exr"}).status, 0);
    EXPECT_EQ(pixels("b.exr"), pixels("plain.exr"));
}

TEST_F(ViewTest, ChangesNeedTheTokenAndTheRightHost) {
    Command view(folder, {"view", "scene.xml", "-i", "path", "--no-open"});
    const std::string page = url(), host = fmt::format("127.0.0.1:{}", portOf(page));
    const auto answer = [&](const std::string& headers) {
        HttpClient client(portOf(page));
        client.send(fmt::format("POST /command HTTP/1.1\r\n{}Content-Length: 14\r\n\r\n{{\"do\":\"pause\"}}",
                                headers));
        return client.receive(20000);
    };
    EXPECT_THAT(answer("Host: " + host + "\r\n"), HasSubstr("401"));
    EXPECT_THAT(answer("Host: evil.example\r\n"), HasSubstr("403"));
    EXPECT_THAT(get(page, "/command"), HasSubstr("405"));
    waitForPhase(page, "rendering");
    EXPECT_THAT(post(page, R"({"do":"fly"})"), AllOf(HasSubstr("400"), HasSubstr("fly")));
    EXPECT_THAT(post(page, R"({"do":"crop","x":20,"y":0,"width":9,"height":9})"),
                HasSubstr("expected one in the image of 24 x 16"));
    view.signal(SIGKILL);
    view.wait();
}

TEST_F(ViewTest, BeyondLoopbackTheAddressHasAToken) {
    Command view(folder, {"view", "scene.xml", "-i", "path", "--no-open", "--serve-address", "0.0.0.0"});
    const std::string page = url();
    EXPECT_THAT(page, testing::MatchesRegex("http://0\\.0\\.0\\.0:[0-9]+/\\?token=[0-9a-f]+"));
    EXPECT_THAT(get(page, "/"), HasSubstr("401"));
    EXPECT_THAT(get(page, "/state"), HasSubstr("401"));
    EXPECT_THAT(get(page, "/main.js"), HasSubstr("200 OK"));
    EXPECT_THAT(get(page, fmt::format("/{}", page.substr(page.find('?')))), HasSubstr("200 OK"));
    view.signal(SIGTERM);
    view.wait();
}

TEST_F(ViewTest, ServedRendersAreThoseOfTheCommandLine) {
    Command render(folder, {"render", "scene.xml", "--serve", "-i", "path", "--passes", "200000", "-o",
                            "a.exr", "--progress", "none"});
    const std::string page = url();
    const nlohmann::json about = json(get(page, "/about"));
    EXPECT_EQ(about["explores"], false);
    waitForPhase(page, "rendering");
    EXPECT_THAT(post(page, R"({"do":"move","yaw":1})"),
                AllOf(HasSubstr("409"), HasSubstr("paused, saved and stopped")));
    EXPECT_THAT(post(page, R"({"do":"save"})"), HasSubstr("202"));
    ASSERT_TRUE(waitFor("a.exr"));
    EXPECT_THAT(post(page, R"({"do":"stop"})"), HasSubstr("202"));
    const Outcome outcome = render.wait();
    EXPECT_EQ(outcome.status, 3) << outcome.err;
}

/// Tev shows at the end what the file has, to the bit.
TEST_F(ViewTest, TevGetsTheImage) {
    test::FakeTev tev;
    Command render(folder, {"render", "scene.xml", "-i", "path", "--passes", "30", "-o", "a.exr", "--tev",
                            tev.address()});
    ASSERT_TRUE(tev.accept(20000));
    std::vector<float> shown;
    for (std::string packet = tev.packet(); !packet.empty(); packet = tev.packet()) {
        test::PacketReader reader(packet);
        reader.number<uint32_t>();
        if (reader.number<char>() != 6) continue;
        reader.number<char>();
        reader.text();
        reader.number<int32_t>();
        for (int i = 0; i < 3; ++i) reader.text();
        for (int i = 0; i < 4; ++i) reader.number<int32_t>();
        for (int i = 0; i < 6; ++i) reader.number<int64_t>();
        shown.resize(reader.rest() / sizeof(float));
        for (float& value : shown) value = reader.number<float>();
    }
    EXPECT_EQ(render.wait().status, 0);
    EXPECT_EQ(shown, pixels("a.exr"));
}

/// A tev that takes nothing more, or goes away, costs a rendering its farewell at most.
TEST_F(ViewTest, TevThatStallsOrGoesHoldsNobodyUp) {
    test::FakeTev tev;
    Command render(folder, {"render", "scene.xml", "-D", "width=3000", "-i", "path", "--passes", "2", "-o",
                            "a.exr", "--tev", tev.address()});
    ASSERT_TRUE(tev.accept(20000));
    EXPECT_EQ(render.wait().status, 0) << "without a byte being read";
    Command other(
        folder, {"render", "scene.xml", "-i", "path", "--time", "1s", "-o", "b.exr", "--tev", tev.address()});
    ASSERT_TRUE(tev.accept(20000));
    tev.hangUp();
    const Outcome outcome = other.wait();
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.err, HasSubstr("tev at 127.0.0.1"));
}

TEST_F(ViewTest, MistakesAreTold) {
    Command first(folder, {"view", "scene.xml", "-i", "path", "--no-open"});
    const std::string port = fmt::format("{}", portOf(url()));
    const std::pair<Words, std::string> cases[] = {
        {{"view", "scene.xml", "--no-open", "--port", port, "-o", "b.exr"}, "Address already in use"},
        {{"view", "scene.xml", "--no-open", "--port", "x"}, "'x' is not a port"},
        {{"view", "scene.xml", "--no-open", "--port", "70000"}, "'70000' is not a port"},
        {{"view", "absent.xml", "--no-open"}, "absent.xml"},
        {{"view", "scene.xml", "--no-open", "-i", "magic"}, "magic"},
        {{"view", "scene.xml", "--no-open", "--sensor", "all"}, "name it"},
        {{"view", "scene.xml", "--no-open", "--serve-address", "here"}, "'here' is not an address"},
        {{"view", "scene.xml", "--no-open", "--tev", "host:x"}, "HOST:PORT"},
        {{"render", "scene.xml", "--serve-address", "0.0.0.0"}, "--serve"},
        {{"render", "scene.xml", "--serve", "--sensor", "all"}, "one rendering"},
    };
    for (const auto& [words, message] : cases) {
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.status, 2) << testing::PrintToString(words) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(message)) << testing::PrintToString(words);
    }
    first.signal(SIGTERM);
    first.wait();
}

/// The page in headless Chromium: web/test/live.mjs opens it, operates it and prints what it saw.
TEST_F(ViewTest, PageWorksInABrowser) {
    const fs::path web = fs::path(METROLUX_BINARY_DIR) / "web";
    if (!fs::exists(web / "node_modules"))
        GTEST_SKIP() << "without npm there is no playwright-core to drive the page";
    if (std::system("command -v chromium >/dev/null") != 0) GTEST_SKIP() << "chromium is not installed";
    Command view(folder,
                 {"view", "scene.xml", "-D", "width=40", "-i", "path", "--passes", "1000", "--no-open"});
    const std::string page = url();
    const std::string script =
        fmt::format("cd '{}' && node test/live.mjs '{}' '{}' > '{}' 2>&1", web.string(), page,
                    (folder / "page.json").string(), (folder / "page.log").string());
    const int status = std::system(script.c_str());
    ASSERT_EQ(status, 0) << textOf(folder / "page.log");
    view.signal(SIGTERM);
    view.wait();
    ASSERT_EQ(
        run({"render", "scene.xml", "-D", "width=40", "-i", "path", "--passes", "1000", "-o", "plain.exr"})
            .status,
        0);
    const ImageData plain = readImage(folder / "plain.exr", false);
    const nlohmann::json seen = nlohmann::json::parse(textOf(folder / "page.json"));
    EXPECT_LT(seen["seconds_to_picture"], 2.0);
    EXPECT_LT(seen["seconds_to_turn"], 1.0);
    ASSERT_EQ(seen["pixels"].size(), 4u);
    for (const auto& pixel : seen["pixels"])
        for (int c = 0; c < 3; ++c)
            EXPECT_EQ(pixel["values"][static_cast<size_t>(c)].get<float>(),
                      plain.at(pixel["x"], pixel["y"])[c])
                << pixel;
}

}  // namespace
}  // namespace metrolux::core::cli
