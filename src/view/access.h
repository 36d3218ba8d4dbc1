#pragma once
/// Who may see and steer a rendering.

#include "view/http_server.h"

#include <string>

namespace metrolux::core::view {

/// Hexadecimal digits that nobody guesses.
std::string makeToken();

/// Whether two tokens are the same, in a time that does not tell how many of their characters are.
bool sameToken(const std::string& a, const std::string& b);

class Access {
  public:
    /// `loopback`: only programs of this machine can connect.
    Access(bool loopback, uint16_t port, std::string token)
        : loopback_(loopback), port_(port), token_(std::move(token)) {}
    /// `isPublic`: for what is in every copy of the program.
    /// 0, or the status with which the request is refused; `reason` is for people. On loopback everybody may
    /// look, if the request was meant for this machine: a name that some other site has pointed here is
    /// refused (DNS rebinding). Beyond it everything needs the token. What changes something needs it
    /// everywhere, in a header, which no page of another site can send.
    unsigned refused(const HttpRequest& request, bool isPublic, std::string& reason) const;
    const std::string& token() const { return token_; }

  private:
    bool loopback_;
    uint16_t port_;
    std::string token_;
};

}  // namespace metrolux::core::view
