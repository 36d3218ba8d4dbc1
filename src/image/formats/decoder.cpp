#include "image/formats/decoder.h"

#include "base/error.h"

#include <istream>
#include <iterator>

namespace metrolux::core {
namespace {

template <class T>
std::vector<float> scaled(std::span<const T> values) {
    constexpr float kScale = 1.0f / static_cast<float>(std::numeric_limits<T>::max());
    std::vector<float> result(values.size());
    for (size_t i = 0; i < values.size(); ++i) result[i] = static_cast<float>(values[i]) * kScale;
    return result;
}

}  // namespace

std::vector<std::string> defaultChannels(int count) {
    switch (count) {
        case 1:
            return {"Y"};
        case 2:
            return {"Y", "A"};
        case 3:
            return {"R", "G", "B"};
        default:
            return {"R", "G", "B", "A"};
    }
}

std::vector<float> scaledToOne(std::span<const uint8_t> values) { return scaled(values); }
std::vector<float> scaledToOne(std::span<const uint16_t> values) { return scaled(values); }

namespace {
[[noreturn]] void failAtEnd() { throw Error("the file ends too early"); }
}  // namespace

uint8_t readByte(std::istream& stream) {
    const int byte = stream.get();
    if (byte == std::char_traits<char>::eof()) failAtEnd();
    return static_cast<uint8_t>(byte);
}

std::string readBytes(std::istream& stream, size_t count) {
    // In pieces: the count may be a claim that the file does not keep.
    constexpr size_t kPiece = size_t{1} << 20;
    std::string bytes;
    while (bytes.size() < count) {
        const size_t old = bytes.size(), piece = std::min(kPiece, count - old);
        bytes.resize(old + piece);
        stream.read(bytes.data() + old, static_cast<std::streamsize>(piece));
        if (static_cast<size_t>(stream.gcount()) != piece) failAtEnd();
    }
    return bytes;
}

std::string readRest(std::istream& stream) {
    std::string bytes;
    char piece[1 << 16];
    while (stream.read(piece, sizeof piece), stream.gcount() > 0)
        bytes.append(piece, static_cast<size_t>(stream.gcount()));
    return bytes;
}

}  // namespace metrolux::core
