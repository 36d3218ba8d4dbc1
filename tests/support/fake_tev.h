#pragma once
/// A tev that follows its specification (src/Ipc.cpp of github.com/Tom94/tev), or stalls, or goes away.

#include <arpa/inet.h>
#include <cstdint>
#include <cstring>
#include <netinet/in.h>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <unistd.h>

namespace metrolux::core::test {

/// Reads packets as tev's IpcPacket does, field by field.
class PacketReader {
  public:
    explicit PacketReader(std::string bytes) : bytes_(std::move(bytes)) {}
    template <class T>
    T number() {
        T value{};
        if (at_ + sizeof(T) > bytes_.size()) throw std::runtime_error("beyond the packet");
        std::memcpy(&value, bytes_.data() + at_, sizeof(T));
        at_ += sizeof(T);
        return value;
    }
    std::string text() {
        const size_t end = bytes_.find('\0', at_);
        if (end == std::string::npos) throw std::runtime_error("a text without an end");
        std::string result = bytes_.substr(at_, end - at_);
        at_ = end + 1;
        return result;
    }
    size_t rest() const { return bytes_.size() - at_; }

  private:
    std::string bytes_;
    size_t at_ = 0;
};

/// A port that takes connections.
class FakeTev {
  public:
    FakeTev() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
        ::listen(socket_, 4);
        socklen_t size = sizeof address;
        ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
        port = ntohs(address.sin_port);
    }
    ~FakeTev() {
        hangUp();
        ::close(socket_);
    }
    bool accept(int milliseconds = 5000) {
        pollfd wanted{socket_, POLLIN, 0};
        if (::poll(&wanted, 1, milliseconds) <= 0) return false;
        connection_ = ::accept(socket_, nullptr, nullptr);
        return connection_ >= 0;
    }
    void hangUp() {
        if (connection_ >= 0) ::close(connection_);
        connection_ = -1;
    }
    /// The next packet; empty when none comes.
    std::string packet() {
        std::string bytes = take(4);
        if (bytes.size() < 4) return {};
        uint32_t length = 0;
        std::memcpy(&length, bytes.data(), 4);
        return bytes + take(length - 4);
    }
    std::string address() const { return "127.0.0.1:" + std::to_string(port); }
    uint16_t port = 0;

  private:
    std::string take(size_t count) {
        std::string bytes(count, '\0');
        size_t at = 0;
        while (at < count) {
            pollfd wanted{connection_, POLLIN, 0};
            if (::poll(&wanted, 1, 3000) <= 0) break;
            const ssize_t n = ::recv(connection_, bytes.data() + at, count - at, 0);
            if (n <= 0) break;
            at += static_cast<size_t>(n);
        }
        bytes.resize(at);
        return bytes;
    }
    int socket_, connection_ = -1;
};

}  // namespace metrolux::core::test
