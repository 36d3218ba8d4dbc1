#include "view/http_server.h"

#include "base/clock.h"
#include "base/error.h"
#include "support/http_client.h"
#include "view/http_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <vector>

namespace metrolux::core::view {
namespace {

using std::chrono::milliseconds;
using test::HttpClient;
using testing::HasSubstr;
using testing::StartsWith;

HttpLimits fewConnections() {
    HttpLimits limits;
    limits.connections = 8;
    return limits;
}

HttpLimits quickLimits() {
    HttpLimits limits = fewConnections();
    limits.request = limits.response = limits.wait = milliseconds(1000);
    return limits;
}

/// Answers /echo with path and query, /big with 8 MB, and /wait once `ready`.
class HttpServerTest : public testing::Test {
  protected:
    explicit HttpServerTest(const HttpLimits& limits = fewConnections()) : server("127.0.0.1", 0, limits) {
        server.start([this](const HttpRequest& request, bool last) -> std::optional<HttpResponse> {
            ++asked;
            if (request.path == "/big") return HttpResponse{200, "text/plain", big, {}};
            if (request.path == "/throw") throw std::runtime_error("a bug");
            if (request.path == "/wait" && !ready && !last) return std::nullopt;
            std::string text = request.method + " " + request.path + " " + request.body;
            for (const auto& [name, value] : request.query) text += " " + name + "=" + value;
            return textResponse(last ? 504 : 200, text);
        });
    }
    /// It still answers, and at once.
    void expectAlive() {
        HttpClient client(server.port());
        EXPECT_THAT(client.get("/alive"), HasSubstr("200 OK"));
    }

    const std::shared_ptr<const std::string> big = std::make_shared<const std::string>(8 << 20, 'x');
    std::atomic<bool> ready{false};
    std::atomic<int> asked{0};
    HttpServer server;
};

class ImpatientHttpServerTest : public HttpServerTest {
  protected:
    ImpatientHttpServerTest() : HttpServerTest(quickLimits()) {}
};

TEST_F(HttpServerTest, AnswersOneRequestAfterTheOther) {
    HttpClient client(server.port());
    EXPECT_THAT(client.get("/a%20b?x=1&y=%2F&x=2&z"), HasSubstr("GET /a b  x=1 y=/ z="));
    client.send("POST /c HTTP/1.1\r\nHost: h\r\nContent-Length: 5\r\n\r\nhello");
    EXPECT_THAT(client.receive(), HasSubstr("POST /c hello"));
    EXPECT_THAT(client.get("/big"), HasSubstr("xxxx"));
    EXPECT_FALSE(client.isClosed());
}

TEST_F(HttpServerTest, GarbageGetsAnErrorAndLosesTheConnection) {
    const std::string longLine(40000, 'a');
    const std::pair<std::string, std::string> cases[] = {
        {std::string("\x16\x03\x01\0\xff\xfe garbage\r\n\r\n", 20), "400"},
        {"GET / HTTP/1.1\r\nno colon\r\n\r\n", "400"},
        {"GET /" + longLine + " HTTP/1.1\r\n\r\n", "431"},
        {"GET / HTTP/1.1\r\nX: " + longLine + "\r\n\r\n", "431"},
        {"POST / HTTP/1.1\r\nContent-Length: 1000000\r\n\r\n", "413"},
        {"POST / HTTP/1.1\r\nContent-Length: -5\r\n\r\n", "400"},
        {"POST / HTTP/1.1\r\nContent-Length: 99999999999999999999999\r\n\r\n", "400"},
    };
    for (const auto& [bytes, status] : cases) {
        HttpClient client(server.port());
        client.send(bytes);
        EXPECT_THAT(client.receive(), StartsWith("HTTP/1.1 " + status)) << bytes.substr(0, 40);
        client.receive(500);
        EXPECT_TRUE(client.isClosed()) << bytes.substr(0, 40);
        expectAlive();
    }
}

TEST_F(HttpServerTest, AHandlerThatThrowsIsAnError) {
    HttpClient client(server.port());
    EXPECT_THAT(client.get("/throw"), AllOf(HasSubstr("500"), HasSubstr("a bug")));
    expectAlive();
}

TEST_F(ImpatientHttpServerTest, WhoSendsSlowlyIsDropped) {
    HttpClient client(server.port());
    const double start = steadySeconds();
    client.send("GET / HT");
    while (!client.isClosed() && steadySeconds() < start + 10) {
        client.send("x");  // a byte now and then does not help
        client.receive(50);
    }
    EXPECT_TRUE(client.isClosed());
    EXPECT_LT(steadySeconds() - start, 5);
}

TEST_F(ImpatientHttpServerTest, WhoDoesNotReadIsDropped) {
    {
        HttpClient client(server.port());
        client.send("GET /big HTTP/1.1\r\nHost: h\r\n\r\n");
        for (int i = 0; i < 100 && big.use_count() == 1; ++i) ::usleep(10000);
        EXPECT_GT(big.use_count(), 1);
        expectAlive();
        for (int i = 0; i < 1000 && big.use_count() > 1; ++i) ::usleep(10000);
        EXPECT_EQ(big.use_count(), 1) << "nothing is kept for it";
    }
    expectAlive();
}

TEST_F(HttpServerTest, SilentConnectionsMakeRoom) {
    std::vector<std::unique_ptr<HttpClient>> silent;
    for (int i = 0; i < 40; ++i) {
        silent.push_back(std::make_unique<HttpClient>(server.port()));
        silent.back()->send("GET / HTTP/1.1\r\nX:");
    }
    expectAlive();
}

TEST_F(ImpatientHttpServerTest, WaitingConnectionsAreBounded) {
    std::vector<std::unique_ptr<HttpClient>> waiting;
    for (int i = 0; i < 8; ++i) {
        waiting.push_back(std::make_unique<HttpClient>(server.port()));
        waiting.back()->send("GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
    }
    for (int i = 0; i < 100 && asked < 8; ++i) ::usleep(5000);
    HttpClient one(server.port());
    EXPECT_EQ(one.get("/alive"), "") << "no room";
    for (auto& client : waiting) EXPECT_THAT(client->receive(), HasSubstr("504"));
    expectAlive();
}

TEST_F(ImpatientHttpServerTest, ARequestWaitsForNews) {
    HttpClient client(server.port()), gone(server.port());
    client.send("GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
    gone.send("GET /wait HTTP/1.1\r\nHost: h\r\n\r\n");
    EXPECT_EQ(client.receive(50), "");
    gone.close();
    ready = true;
    server.notify();
    EXPECT_THAT(client.receive(), HasSubstr("200 OK"));
    ready = false;
    EXPECT_THAT(client.get("/wait"), HasSubstr("504")) << "not forever, and a second time";
}

TEST_F(HttpServerTest, TheEndDoesNotWaitForAnybody) {
    auto other = std::make_unique<HttpServer>("127.0.0.1", 0);
    other->start([](const HttpRequest&, bool) { return std::optional<HttpResponse>(); });
    HttpClient waits(other->port()), silent(other->port());
    waits.send("GET / HTTP/1.1\r\nHost: h\r\n\r\n");
    waits.receive(50);
    const double start = steadySeconds();
    other.reset();
    EXPECT_LT(steadySeconds() - start, 1);
}

TEST_F(HttpServerTest, PortsAndAddressesThatCannotBe) {
    const auto message = [](const std::string& address, uint16_t port) {
        try {
            const HttpServer second(address, port);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_THAT(message("127.0.0.1", server.port()),
                AllOf(HasSubstr("port " + std::to_string(server.port())), HasSubstr("in use")));
    EXPECT_THAT(message("localhost", 0), HasSubstr("'localhost' is not an address"));
    EXPECT_THAT(message("192.0.2.1", 0), HasSubstr("cannot listen on 192.0.2.1"));
}

TEST(HttpText, DecodesWhatIsEncoded) { EXPECT_EQ(percentDecoded("a%2Fb+c%zz%2"), "a/b c%zz%2"); }

}  // namespace
}  // namespace metrolux::core::view
