#include "view/http_server.h"

#include "base/error.h"
#include "view/http_text.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <algorithm>
#include <atomic>
#include <list>
#include <pthread.h>
#include <thread>

namespace metrolux::core::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using Clock = std::chrono::steady_clock;

/// A string that somebody else may hold, too.
struct SharedBody {
    using value_type = std::shared_ptr<const std::string>;
    static uint64_t size(const value_type& body) { return body ? body->size() : 0; }
    struct writer {
        using const_buffers_type = asio::const_buffer;
        template <bool isRequest, class Fields>
        writer(const http::header<isRequest, Fields>&, const value_type& body) : body_(body) {}
        void init(beast::error_code& code) { code = {}; }
        boost::optional<std::pair<const_buffers_type, bool>> get(beast::error_code& code) {
            code = {};
            if (!body_) return boost::none;
            return {{const_buffers_type(body_->data(), body_->size()), false}};
        }
        value_type body_;
    };
};

std::string text(beast::string_view view) { return {view.data(), view.size()}; }

HttpRequest requestOf(http::request<http::string_body>& message) {
    HttpRequest request;
    request.method = text(message.method_string());
    splitTarget(text(message.target()), request.path, request.query);
    for (const auto& field : message) {
        std::string name = text(field.name_string());
        std::transform(name.begin(), name.end(), name.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        request.headers.emplace(std::move(name), text(field.value()));
    }
    request.body = std::move(message.body());
    return request;
}

}  // namespace

std::string HttpRequest::header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
}

HttpResponse textResponse(unsigned status, std::string text, std::string type) {
    return {status, std::move(type), std::make_shared<const std::string>(std::move(text)), {}};
}

struct HttpServer::Impl {
    class Connection;
    asio::io_context io{1};
    asio::executor_work_guard<asio::io_context::executor_type> busy{io.get_executor()};
    tcp::acceptor acceptor{io};
    asio::steady_timer pause{io};  ///< after a failed accept
    HttpLimits limits;
    Handler handler;
    std::list<std::shared_ptr<Connection>> connections;
    std::atomic<size_t> writing{0};
    std::thread thread;

    void accept();
    void admit(tcp::socket socket);
    void askAgain();
};

/// One request after the other.
class HttpServer::Impl::Connection : public std::enable_shared_from_this<Connection> {
  public:
    Connection(Impl& server, tcp::socket socket)
        : server_(server), stream_(std::move(socket)), wait_(server.io), since_(Clock::now()) {}

    void read() {
        state_ = State::Reading;
        since_ = Clock::now();
        parser_.emplace();
        parser_->header_limit(static_cast<std::uint32_t>(server_.limits.headerBytes));
        parser_->body_limit(server_.limits.bodyBytes);
        stream_.expires_after(server_.limits.request);
        http::async_read(stream_, buffer_, *parser_,
                         [self = shared_from_this()](beast::error_code code, size_t) { self->onRead(code); });
    }
    /// Tries to answer a request that waits.
    void ask(bool last) {
        if (state_ != State::Waiting) return;
        std::optional<HttpResponse> response;
        try {
            response = server_.handler(request_, last);
        } catch (const std::exception& problem) {
            response = textResponse(500, problem.what());
        }
        if (!response && last) response = textResponse(503, "no answer");
        if (response) write(*std::move(response), keepAlive_);
    }
    void close() {
        wait_.cancel();
        beast::error_code ignored;
        stream_.socket().close(ignored);
    }
    bool isReading() const { return state_ == State::Reading; }
    Clock::time_point since() const { return since_; }

  private:
    enum class State { Reading, Waiting, Writing };

    void onRead(beast::error_code code) {
        if (code) {
            if (const unsigned status = statusOf(code))
                return write(textResponse(status, code.message()), false);
            return finish();
        }
        http::request<http::string_body> message = parser_->release();
        keepAlive_ = message.keep_alive();
        request_ = requestOf(message);
        state_ = State::Waiting;
        ++requests_;
        // Who waits sends nothing; a read that ends early is a viewer that went away.
        stream_.expires_never();
        wait_.expires_after(server_.limits.wait);
        wait_.async_wait([self = shared_from_this()](beast::error_code canceled) {
            if (!canceled) self->ask(true);
        });
        ask(false);
        if (state_ == State::Waiting) watch();
    }
    /// Notices that the viewer has closed while its request waits.
    void watch() {
        stream_.socket().async_wait(tcp::socket::wait_read,
                                    [self = shared_from_this(), request = requests_](beast::error_code code) {
                                        if (self->state_ != State::Waiting || request != self->requests_)
                                            return;
                                        beast::error_code failed;
                                        if (code || self->stream_.socket().available(failed) == 0 || failed)
                                            self->finish();
                                    });
    }
    static unsigned statusOf(beast::error_code code) {
        if (code == http::error::header_limit || code == http::error::buffer_overflow) return 431;
        if (code == http::error::body_limit) return 413;
        if (code == beast::error::timeout || code == http::error::end_of_stream ||
            code == http::error::partial_message ||
            code.category() != http::make_error_code(http::error{}).category())
            return 0;
        return 400;
    }
    void write(HttpResponse response, bool keepAlive) {
        state_ = State::Writing;
        wait_.cancel();
        ++server_.writing;
        response_.emplace();
        response_->version(11);
        response_->result(response.status);
        response_->keep_alive(keepAlive);
        response_->set(http::field::content_type, response.type);
        for (const auto& [name, value] : response.headers) response_->set(name, value);
        response_->body() = std::move(response.body);
        response_->prepare_payload();
        if (request_.method == "HEAD") response_->body() = nullptr;
        stream_.expires_after(server_.limits.response);
        http::async_write(stream_, *response_,
                          [self = shared_from_this(), keepAlive](beast::error_code code, size_t) {
                              --self->server_.writing;
                              self->response_.reset();
                              if (code || !keepAlive) return self->finish();
                              self->read();
                          });
    }
    void finish() {
        beast::error_code ignored;
        stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
        close();
        server_.connections.remove(shared_from_this());
    }

    Impl& server_;
    beast::tcp_stream stream_;
    asio::steady_timer wait_;
    beast::flat_buffer buffer_{64 << 10};
    std::optional<http::request_parser<http::string_body>> parser_;
    std::optional<http::response<SharedBody>> response_;
    HttpRequest request_;
    bool keepAlive_ = false;
    uint64_t requests_ = 0;
    State state_ = State::Reading;
    Clock::time_point since_;
};

void HttpServer::Impl::accept() {
    acceptor.async_accept([this](beast::error_code code, tcp::socket socket) {
        if (code == asio::error::operation_aborted) return;
        if (!code) {
            admit(std::move(socket));
            return accept();
        }
        // No descriptors are left, perhaps: others will be closed.
        pause.expires_after(std::chrono::milliseconds(200));
        pause.async_wait([this](beast::error_code canceled) {
            if (!canceled) accept();
        });
    });
}

/// Where there are too many, whoever has been silent longest makes room: a viewer that asks and reads stays.
void HttpServer::Impl::admit(tcp::socket socket) {
    if (connections.size() >= limits.connections) {
        const auto silent =
            std::min_element(connections.begin(), connections.end(), [](const auto& a, const auto& b) {
                return std::pair(!a->isReading(), a->since()) < std::pair(!b->isReading(), b->since());
            });
        if (!(*silent)->isReading()) return;  // the new one is closed
        const std::shared_ptr<Connection> leaving = *silent;
        connections.erase(silent);
        leaving->close();
    }
    beast::error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    connections.push_back(std::make_shared<Connection>(*this, std::move(socket)));
    connections.back()->read();
}

void HttpServer::Impl::askAgain() {
    // An answer may end a connection, which takes it out of the list.
    const std::vector<std::shared_ptr<Connection>> all(connections.begin(), connections.end());
    for (const std::shared_ptr<Connection>& connection : all) connection->ask(false);
}

HttpServer::HttpServer(const std::string& address, uint16_t port, HttpLimits limits)
    : impl_(std::make_unique<Impl>()) {
    impl_->limits = limits;
    beast::error_code code;
    const asio::ip::address at = asio::ip::make_address(address, code);
    if (code)
        throw Error("'{}' is not an address to listen on, expected for example 127.0.0.1 or 0.0.0.0",
                    address);
    const tcp::endpoint endpoint(at, port);
    impl_->acceptor.open(endpoint.protocol(), code);
    if (!code) impl_->acceptor.set_option(asio::socket_base::reuse_address(true), code);
    if (!code) impl_->acceptor.bind(endpoint, code);
    if (!code) impl_->acceptor.listen(asio::socket_base::max_listen_connections, code);
    if (code) throw Error("cannot listen on {} port {}: {}", address, port, code.message());
    port_ = impl_->acceptor.local_endpoint().port();
}

HttpServer::~HttpServer() {
    if (!impl_->thread.joinable()) return;
    asio::post(impl_->io, [this] {
        beast::error_code ignored;
        impl_->acceptor.close(ignored);
        impl_->pause.cancel();
        for (const auto& connection : impl_->connections) connection->close();
        impl_->connections.clear();
    });
    impl_->busy.reset();
    impl_->thread.join();
}

void HttpServer::start(Handler handler) {
    impl_->handler = std::move(handler);
    impl_->accept();
    impl_->thread = std::thread([this] {
        ::pthread_setname_np(::pthread_self(), "metrolux-http");  // for tools/view_slowdown.py
        impl_->io.run();
    });
}

void HttpServer::notify() {
    asio::post(impl_->io, [this] { impl_->askAgain(); });
}

void HttpServer::drain(std::chrono::milliseconds most) {
    const auto end = Clock::now() + most;
    while (impl_->writing > 0 && Clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

}  // namespace metrolux::core::view
