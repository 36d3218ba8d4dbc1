#include "view/access.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <random>

namespace metrolux::core::view {

std::string makeToken() {
    std::random_device device;
    std::string token;
    for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", device() & 0xffffffffu);
    return token;
}

bool sameToken(const std::string& a, const std::string& b) {
    unsigned difference = a.size() == b.size() ? 0 : 1;
    for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        difference |=
            static_cast<unsigned>(static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]));
    return difference == 0;
}

unsigned Access::refused(const HttpRequest& request, bool isPublic, std::string& reason) const {
    std::string host = request.header("host");
    std::transform(host.begin(), host.end(), host.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (loopback_) {
        const std::string port = fmt::format(":{}", port_);
        if (host != "127.0.0.1" + port && host != "localhost" + port && host != "[::1]" + port) {
            reason = "the request is for another host";
            return 403;
        }
    }
    const std::string origin = request.header("origin");
    if (!origin.empty() && origin != "http://" + host) {
        reason = "the request comes from a page of another site";
        return 403;
    }
    const bool changes = request.method != "GET" && request.method != "HEAD";
    if ((loopback_ || isPublic) && !changes) return 0;
    std::string given = request.header("x-metrolux-token");
    if (given.empty() && !changes)
        if (const auto query = request.query.find("token"); query != request.query.end())
            given = query->second;
    if (sameToken(given, token_)) return 0;
    reason = "the token of the address that metrolux has printed is missing or wrong";
    return 401;
}

}  // namespace metrolux::core::view
