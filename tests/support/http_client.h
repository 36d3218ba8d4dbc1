#pragma once
/// A viewer that says exactly what a test wants it to say.

#include <arpa/inet.h>
#include <cstdint>
#include <netinet/in.h>
#include <poll.h>
#include <string>
#include <sys/socket.h>
#include <unistd.h>

namespace metrolux::core::test {

class HttpClient {
  public:
    explicit HttpClient(uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    }
    ~HttpClient() { close(); }
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;

    bool isConnected() const { return connected_; }
    void close() {
        if (socket_ >= 0) ::close(socket_);
        socket_ = -1;
    }
    void send(const std::string& bytes) const {
        (void)!::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    }
    /// What arrives until a response is whole, the other side closes or `milliseconds` without a byte have
    /// passed.
    std::string receive(int milliseconds = 3000) {
        std::string all;
        char buffer[65536];
        while (!isWhole(all)) {
            pollfd wanted{socket_, POLLIN, 0};
            if (::poll(&wanted, 1, milliseconds) <= 0) break;
            const ssize_t n = ::recv(socket_, buffer, sizeof buffer, 0);
            if (n <= 0) {
                closed_ = true;
                break;
            }
            all.append(buffer, static_cast<size_t>(n));
        }
        return all;
    }
    /// The other side has closed; known after receive().
    bool isClosed() const { return closed_; }
    std::string get(const std::string& target, const std::string& more = {}, int milliseconds = 3000) {
        send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\n" + more + "\r\n");
        return receive(milliseconds);
    }

  private:
    static bool isWhole(const std::string& text) {
        const size_t end = text.find("\r\n\r\n"), length = text.find("Content-Length: ");
        if (end == std::string::npos || length == std::string::npos || length > end) return false;
        return text.size() >= end + 4 + std::stoul(text.substr(length + 16));
    }
    int socket_;
    bool connected_ = false, closed_ = false;
};

}  // namespace metrolux::core::test
