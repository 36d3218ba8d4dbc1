#pragma once
/// A rendering that others can watch: by the page of a small server, in tev, or both.

#include "view/http_server.h"
#include "view/routes.h"
#include "view/tev_client.h"

namespace metrolux::core::view {

struct LiveOptions {
    bool serves = false;
    std::string address = "127.0.0.1";
    uint16_t port = 0;  ///< 0: any that is free
    std::string tev;    ///< HOST:PORT, or empty
};

class LiveView {
  public:
    /// Listens at once, so that a page can be loaded while the scene is. Throws Error.
    LiveView(const LiveOptions& options, BoardInfo info);
    /// Viewers that are there see how it ended.
    ~LiveView();
    LiveView(const LiveView&) = delete;
    LiveView& operator=(const LiveView&) = delete;

    Board& board() { return board_; }
    /// Of the page; empty without a server.
    const std::string& url() const { return url_; }
    /// What the threads of viewers had to say since the last call, for the thread that reports.
    std::vector<std::string> takeWarnings();

  private:
    void notify();
    Board board_;
    std::optional<Routes> routes_;
    std::string url_;
    std::mutex mutex_;
    std::vector<std::string> warnings_;
    std::unique_ptr<TevClient> tev_;
    std::unique_ptr<HttpServer> server_;
};

}  // namespace metrolux::core::view
