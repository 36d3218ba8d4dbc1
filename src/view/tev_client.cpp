#include "view/tev_client.h"

#include "base/clock.h"
#include "base/error.h"
#include "view/tev_packets.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace metrolux::core::view {
namespace {

constexpr const char* kTevPort = "14158";
/// Seconds for a connection, for a frame to be taken, for the last one, and between attempts.
constexpr double kConnect = 2, kTake = 10, kTakeLast = 2, kRetry = 3;
/// Bytes of pixels in a packet.
constexpr size_t kBand = 4 << 20;

bool waitFor(int socket, short events, double seconds) {
    pollfd wanted{socket, events, 0};
    return ::poll(&wanted, 1, static_cast<int>(std::max(0.0, seconds) * 1000)) > 0;
}

/// The error of a connection that has been begun; 0: it stands.
int connectionError(int socket) {
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
    return error;
}

}  // namespace

TevClient::TevClient(const std::string& address, Board& board, std::function<void(const std::string&)> warn)
    : board_(board), warn_(std::move(warn)) {
    const size_t colon = address.rfind(':');
    host_ = address.substr(0, colon);
    port_ = colon == std::string::npos ? kTevPort : address.substr(colon + 1);
    unsigned number = 0;
    const auto [end, code] = std::from_chars(port_.data(), port_.data() + port_.size(), number);
    if (host_.empty() || code != std::errc() || end != port_.data() + port_.size() || number < 1 ||
        number > 65535)
        throw Error("--tev {}: expected HOST:PORT, for example 127.0.0.1:{}", address, kTevPort);
    board_.wantAlways();
    thread_ = std::thread([this] { run(); });
}

TevClient::~TevClient() {
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

void TevClient::notify() {
    {
        const std::lock_guard lock(mutex_);
        news_ = true;
    }
    wake_.notify_all();
}

void TevClient::run() {
    for (bool last = false; !last;) {
        {
            std::unique_lock lock(mutex_);
            wake_.wait_for(lock, std::chrono::milliseconds(200), [this] { return news_ || ends_; });
            news_ = false;
            last = ends_;
        }
        const BoardState state = board_.state();
        if (!hasNews(state)) continue;
        if (socket_ < 0 && (steadySeconds() < retryAt_ || !connect())) continue;
        deadline_ = steadySeconds() + (last ? kTakeLast : kTake);
        if (!sendNews(state)) disconnect("it has taken no picture for too long, or closed");
    }
    if (socket_ >= 0) ::close(socket_);
}

bool TevClient::connect() {
    addrinfo hints{}, *all = nullptr;
    hints.ai_socktype = SOCK_STREAM;
    std::string why;
    if (const int code = ::getaddrinfo(host_.c_str(), port_.c_str(), &hints, &all)) {
        why = ::gai_strerror(code);
        all = nullptr;
    }
    for (const addrinfo* a = all; a && socket_ < 0; a = a->ai_next) {
        const int socket =
            ::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol);
        if (socket < 0) continue;
        int error = ::connect(socket, a->ai_addr, a->ai_addrlen) == 0 ? 0 : errno;
        if (error == EINPROGRESS)
            error = waitFor(socket, POLLOUT, kConnect) ? connectionError(socket) : ETIMEDOUT;
        if (error == 0) {
            socket_ = socket;
        } else {
            why = std::strerror(error);
            ::close(socket);
        }
    }
    if (all) ::freeaddrinfo(all);
    if (socket_ < 0) disconnect(why);
    return socket_ >= 0;
}

/// Says so once for each time that tev was there.
void TevClient::disconnect(const std::string& why) {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
    shown_.clear();
    retryAt_ = steadySeconds() + kRetry;
    if (!warned_) warn_(fmt::format("tev at {}:{} shows nothing: {}", host_, port_, why));
    warned_ = true;
}

bool TevClient::send(const std::string& packet) {
    for (size_t at = 0; at < packet.size();) {
        const ssize_t sent = ::send(socket_, packet.data() + at, packet.size() - at, MSG_NOSIGNAL);
        if (sent > 0) {
            at += static_cast<size_t>(sent);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) {
            if (ends_) deadline_ = std::min(deadline_, steadySeconds() + kTakeLast);
            if (steadySeconds() >= deadline_) return false;
            waitFor(socket_, POLLOUT, std::min(0.5, deadline_ - steadySeconds()));
        } else {
            return false;
        }
    }
    return true;
}

bool TevClient::hasNews(const BoardState& state) const {
    if (state.sides.size() < shown_.size()) return true;
    for (size_t i = 0; i < state.sides.size(); ++i) {
        const auto& frame = state.sides[i].frame;
        if (frame && frame->scale == 1 && (i >= shown_.size() || shown_[i].version < frame->version))
            return true;
    }
    return false;
}

bool TevClient::sendNews(const BoardState& state) {
    while (shown_.size() > state.sides.size()) {
        if (!shown_.back().name.empty() && !send(tevCloseImage(shown_.back().name))) return false;
        shown_.pop_back();
    }
    shown_.resize(state.sides.size());
    for (size_t i = 0; i < state.sides.size(); ++i)
        if (!sendSide(i, state.sides[i])) return false;
    return true;
}

bool TevClient::sendSide(size_t side, const SideState& state) {
    const std::shared_ptr<const Frame>& frame = state.frame;
    Shown& shown = shown_[side];
    if (!frame || frame->scale != 1 || frame->version <= shown.version) return true;
    const int width = frame->window.width, height = frame->window.height;
    const std::string name =
        fmt::format("{} ({}{})", board_.info().scene, state.integrator, side > 0 ? ", right" : "");
    if (shown.name != name || shown.width != width || shown.height != height) {
        if (!shown.name.empty() && !send(tevCloseImage(shown.name))) return false;
        if (!send(tevCreateImage(name, width, height))) return false;
        shown = {name, width, height, 0};
    }
    const size_t row = 3 * static_cast<size_t>(width);
    const int rows = static_cast<int>(std::max<size_t>(1, kBand / (row * sizeof(float))));
    for (int y = 0; y < height; y += rows) {
        const int count = std::min(rows, height - y);
        const std::span<const float> band(frame->color.data() + row * static_cast<size_t>(y),
                                          row * static_cast<size_t>(count));
        if (!send(tevUpdateImage(name, y, width, count, band))) return false;
    }
    shown.version = frame->version;
    warned_ = false;
    return true;
}

}  // namespace metrolux::core::view
