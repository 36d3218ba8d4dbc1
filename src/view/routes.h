#pragma once
/// What the page asks the server: docs/reference/view.md lists the requests.

#include "view/access.h"
#include "view/board.h"

#include <list>

namespace metrolux::core::view {

class Routes {
  public:
    Routes(Board& board, Access access) : board_(board), access_(std::move(access)) {}
    /// As HttpServer::Handler.
    std::optional<HttpResponse> operator()(const HttpRequest& request, bool last);

  private:
    using Answer = std::optional<HttpResponse>;
    Answer route(const HttpRequest& request, bool last);
    HttpResponse file(const std::string& path) const;
    HttpResponse about() const;
    Answer state(const HttpRequest& request, bool last);
    Answer frame(const HttpRequest& request, bool last);
    Answer pixel(const HttpRequest& request, bool last);
    HttpResponse command(const HttpRequest& request);

    /// Pixels as they are sent. What viewers take slowly is kept as long, so that there is a limit.
    struct Encoded {
        std::string key;
        std::weak_ptr<const std::string> bytes;
    };
    static constexpr size_t kMostEncoded = 6;
    /// Null: too many viewers are slow.
    std::shared_ptr<const std::string> encoded(const std::string& key, std::span<const float> values);

    Board& board_;
    Access access_;
    std::list<Encoded> sent_;
    std::shared_ptr<const std::string> newest_[kSides];
};

}  // namespace metrolux::core::view
