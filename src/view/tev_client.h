#pragma once
/// Shows a rendering in tev. A tev that is not there, stalls or goes away costs its own thread time, and
/// nobody else.

#include "view/board.h"

#include <thread>

namespace metrolux::core::view {

class TevClient {
  public:
    /// `address`: "HOST:PORT" or "HOST" (tev's own port). Throws Error for what is neither. `warn` may be
    /// called by another thread.
    TevClient(const std::string& address, Board& board, std::function<void(const std::string&)> warn);
    /// Sends the last frame if tev takes it in time.
    ~TevClient();
    TevClient(const TevClient&) = delete;
    TevClient& operator=(const TevClient&) = delete;

    /// There may be a new frame. Any thread may call it.
    void notify();

  private:
    /// An image in tev.
    struct Shown {
        std::string name;
        int width = 0, height = 0;
        uint64_t version = 0;
    };
    void run();
    bool connect();
    void disconnect(const std::string& why);
    bool send(const std::string& packet);
    bool hasNews(const BoardState& state) const;
    bool sendNews(const BoardState& state);
    bool sendSide(size_t side, const SideState& state);

    std::string host_, port_;
    Board& board_;
    std::function<void(const std::string&)> warn_;
    std::mutex mutex_;
    std::condition_variable wake_;
    bool news_ = false;
    std::atomic<bool> ends_{false};
    int socket_ = -1;
    double retryAt_ = 0, deadline_ = 0;
    bool warned_ = false;
    std::vector<Shown> shown_;
    std::thread thread_;
};

}  // namespace metrolux::core::view
