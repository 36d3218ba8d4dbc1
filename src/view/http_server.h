#pragma once
/// A small HTTP/1.1 server for the live view. Whoever talks to it cannot disturb the program: it has one
/// thread, connections, sizes and times are bounded, and nothing is kept for a viewer that does not read.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace metrolux::core::view {

struct HttpRequest {
    std::string method, path;                    ///< "GET", "/state"
    std::map<std::string, std::string> query;    ///< decoded; of a name that repeats, the first
    std::map<std::string, std::string> headers;  ///< names in lower case
    std::string body;
    /// Empty if there is none of this name.
    std::string header(const std::string& name) const;
};

struct HttpResponse {
    unsigned status = 200;
    std::string type = "application/json";
    std::shared_ptr<const std::string> body;  ///< null: empty. Shared, so that many viewers cost one picture
    std::vector<std::pair<std::string, std::string>> headers;
};
HttpResponse textResponse(unsigned status, std::string text, std::string type = "text/plain; charset=utf-8");

struct HttpLimits {
    size_t connections = 32;
    size_t headerBytes = 16 << 10, bodyBytes = 16 << 10;
    std::chrono::milliseconds request{30000};   ///< for a whole request to arrive, waiting for it included
    std::chrono::milliseconds response{30000};  ///< for a whole response to be taken
    std::chrono::milliseconds wait{20000};      ///< that a response may be put off
};

class HttpServer {
  public:
    /// Called by the server's thread, one at a time. Nothing: there is no answer yet. The request is put
    /// before it again at each notify(), and with `last` when it has waited long enough; then there has to be
    /// one.
    using Handler = std::function<std::optional<HttpResponse>(const HttpRequest& request, bool last)>;

    /// Listens at once. `port` 0: any that is free. Throws Error when it cannot.
    HttpServer(const std::string& address, uint16_t port, HttpLimits limits = {});
    /// Closes all connections.
    ~HttpServer();
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    /// Begins to answer.
    void start(Handler handler);
    /// There may be answers for requests that wait. Any thread may call it.
    void notify();
    /// Waits until all that was written has been taken, but not longer.
    void drain(std::chrono::milliseconds most);
    uint16_t port() const { return port_; }

    struct Impl;

  private:
    std::unique_ptr<Impl> impl_;
    uint16_t port_ = 0;
};

}  // namespace metrolux::core::view
