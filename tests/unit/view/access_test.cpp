#include "view/access.h"

#include <gtest/gtest.h>

namespace metrolux::core::view {
namespace {

HttpRequest request(const std::string& method, std::map<std::string, std::string> headers,
                    std::map<std::string, std::string> query = {}) {
    return {method, "/", std::move(query), std::move(headers), {}};
}

unsigned status(const Access& access, const HttpRequest& request, bool isPublic = false) {
    std::string reason;
    const unsigned result = access.refused(request, isPublic, reason);
    EXPECT_EQ(reason.empty(), result == 0);
    return result;
}

TEST(Access, OnLoopbackEverybodyLooksAndTheTokenChanges) {
    const Access access(true, 8000, "secret");
    for (const char* host : {"127.0.0.1:8000", "localhost:8000", "LocalHost:8000", "[::1]:8000"}) {
        EXPECT_EQ(status(access, request("GET", {{"host", host}})), 0u) << host;
        EXPECT_EQ(status(access, request("POST", {{"host", host}})), 401u) << host;
        EXPECT_EQ(status(access, request("POST", {{"host", host}, {"x-metrolux-token", "secret"}})), 0u)
            << host;
    }
    EXPECT_EQ(status(access, request("POST", {{"host", "localhost:8000"}}, {{"token", "secret"}})), 401u)
        << "a form of another site could send that";
}

TEST(Access, NamesThatAnotherSiteHasPointedHereAreRefused) {
    const Access access(true, 8000, "secret");
    for (const char* host :
         {"evil.example:8000", "localhost", "localhost:80", "127.0.0.1.evil.example:8000", ""})
        EXPECT_EQ(status(access, request("GET", {{"host", host}})), 403u) << host;
    EXPECT_EQ(status(access, request("GET", {})), 403u);
}

TEST(Access, PagesOfOtherSitesAreRefused) {
    const Access access(true, 8000, "secret");
    const auto from = [](const char* origin) {
        return request("POST",
                       {{"host", "localhost:8000"}, {"x-metrolux-token", "secret"}, {"origin", origin}});
    };
    EXPECT_EQ(status(access, from("http://localhost:8000")), 0u);
    EXPECT_EQ(status(access, from("http://evil.example")), 403u);
    EXPECT_EQ(status(access, from("null")), 403u);
    EXPECT_EQ(status(access, from("http://127.0.0.1:8000")), 403u);
}

TEST(Access, BeyondLoopbackEverythingNeedsTheToken) {
    const Access access(false, 8000, "secret");
    const char* const host = "render7.example:8000";
    EXPECT_EQ(status(access, request("GET", {{"host", host}})), 401u);
    EXPECT_EQ(status(access, request("GET", {{"host", host}}, {{"token", "wrong!"}})), 401u);
    EXPECT_EQ(status(access, request("GET", {{"host", host}}, {{"token", "secre"}})), 401u);
    EXPECT_EQ(status(access, request("GET", {{"host", host}}, {{"token", "secret"}})), 0u);
    EXPECT_EQ(status(access, request("GET", {{"host", host}, {"x-metrolux-token", "secret"}})), 0u);
    EXPECT_EQ(status(access, request("GET", {{"host", host}}), true), 0u) << "scripts are in every copy";
    EXPECT_EQ(status(access, request("POST", {{"host", host}}), true), 401u);
}

TEST(Access, TokensDiffer) {
    const std::string token = makeToken();
    EXPECT_EQ(token.size(), 32u);
    EXPECT_NE(token, makeToken());
    EXPECT_TRUE(sameToken(token, std::string(token)));
    EXPECT_FALSE(sameToken("", token));
}

}  // namespace
}  // namespace metrolux::core::view
