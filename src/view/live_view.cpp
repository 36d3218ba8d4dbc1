#include "view/live_view.h"

#include <fmt/format.h>

#include <thread>

namespace metrolux::core::view {
namespace {

/// What viewers have to hear of the end and to take the last picture.
constexpr std::chrono::milliseconds kFarewell{500}, kLastPicture{2000};

bool isLoopback(const std::string& address) { return address.starts_with("127.") || address == "::1"; }

}  // namespace

LiveView::LiveView(const LiveOptions& options, BoardInfo info) : board_(std::move(info)) {
    if (options.serves) {
        server_ = std::make_unique<HttpServer>(options.address, options.port);
        const bool loopback = isLoopback(options.address);
        const std::string token = makeToken();
        const bool isV6 = options.address.find(':') != std::string::npos;
        const std::string host = isV6 ? "[" + options.address + "]" : options.address;
        url_ = fmt::format("http://{}:{}/", host, server_->port());
        if (!loopback) url_ += "?token=" + token;
        routes_.emplace(board_, Access(loopback, server_->port(), token));
        server_->start([this](const HttpRequest& request, bool last) { return (*routes_)(request, last); });
    }
    if (!options.tev.empty())
        tev_ = std::make_unique<TevClient>(options.tev, board_, [this](const std::string& text) {
            const std::lock_guard lock(mutex_);
            warnings_.push_back(text);
        });
    board_.onChange([this] { notify(); });
}

void LiveView::notify() {
    if (server_) server_->notify();
    if (tev_) tev_->notify();
}

std::vector<std::string> LiveView::takeWarnings() {
    const std::lock_guard lock(mutex_);
    return std::exchange(warnings_, {});
}

LiveView::~LiveView() {
    board_.change([](BoardState& state) { state.phase = Phase::Ended; });
    board_.onChange({});
    tev_.reset();
    if (!server_ || !board_.isWatched()) return;
    std::this_thread::sleep_for(kFarewell);
    server_->drain(kLastPicture);
}

}  // namespace metrolux::core::view
