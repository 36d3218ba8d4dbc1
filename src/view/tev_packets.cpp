#include "view/tev_packets.h"

#include <bit>
#include <cstring>

namespace metrolux::core::view {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are sent as they lie in memory");

enum class Type : char { CloseImage = 2, CreateImage = 4, UpdateImageV3 = 6 };

class Packet {
  public:
    explicit Packet(Type type) {
        add(uint32_t{0});
        add(type);
    }
    template <class T>
    void add(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto at = bytes_.size();
        bytes_.resize(at + sizeof(T));
        std::memcpy(bytes_.data() + at, &value, sizeof(T));
    }
    void add(const std::string& text) { bytes_.append(text.c_str(), text.size() + 1); }
    void add(std::span<const float> values) {
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    }
    std::string finish() && {
        const auto length = static_cast<uint32_t>(bytes_.size());
        std::memcpy(bytes_.data(), &length, sizeof length);
        return std::move(bytes_);
    }

  private:
    std::string bytes_;
};

const std::string kChannels[] = {"R", "G", "B"};
constexpr char kKeepFocus = 0;

}  // namespace

std::string tevCreateImage(const std::string& name, int width, int height) {
    Packet packet(Type::CreateImage);
    packet.add(kKeepFocus);
    packet.add(name);
    packet.add(int32_t{width});
    packet.add(int32_t{height});
    packet.add(int32_t{3});
    for (const std::string& channel : kChannels) packet.add(channel);
    return std::move(packet).finish();
}

std::string tevUpdateImage(const std::string& name, int y, int width, int height,
                           std::span<const float> pixels) {
    Packet packet(Type::UpdateImageV3);
    packet.add(kKeepFocus);
    packet.add(name);
    packet.add(int32_t{3});
    for (const std::string& channel : kChannels) packet.add(channel);
    for (const int32_t number : {0, y, width, height}) packet.add(number);
    for (const int64_t offset : {0, 1, 2}) packet.add(offset);
    for (int c = 0; c < 3; ++c) packet.add(int64_t{3});  // strides
    packet.add(pixels);
    return std::move(packet).finish();
}

std::string tevCloseImage(const std::string& name) {
    Packet packet(Type::CloseImage);
    packet.add(name);
    return std::move(packet).finish();
}

}  // namespace metrolux::core::view
