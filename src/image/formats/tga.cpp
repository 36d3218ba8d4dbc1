/// Truevision TGA 2.0: gray, color and palettes, plain and in runs.

#include "base/error.h"
#include "image/formats/decoder.h"

#include <algorithm>
#include <array>
#include <istream>

namespace metrolux::core {
namespace {

class TgaDecoder final : public ImageDecoder {
  public:
    explicit TgaDecoder(std::istream& stream) : stream_(stream) {
        info_.format = "targa";
        const std::string header = readBytes(stream, 18);
        const auto byte = [&](size_t i) { return static_cast<unsigned char>(header[i]); };
        const auto word = [&](size_t i) { return byte(i) + 256 * byte(i + 1); };
        kind_ = byte(2) & 7;
        isRuns_ = byte(2) & 8;
        if ((byte(2) & ~8) < kPalette || (byte(2) & ~8) > kGray)
            throw Error("its type is {}, expected 1 to 3 or 9 to 11", byte(2));
        if (kind_ == kPalette && byte(1) != 1) throw Error("it has no palette, expected one");
        firstColor_ = word(3);
        colors_ = byte(1) == 1 ? word(5) : 0;
        const int colorBits = byte(7), bits = byte(16);
        info_.width = word(12);
        info_.height = word(14);
        isMirrored_ = byte(17) & 0x10;
        isTopDown_ = byte(17) & 0x20;
        pixelBytes_ = bytesOf(bits);
        const int ownBits = kind_ == kPalette ? colorBits : bits;
        colorBytes_ = kind_ == kPalette || colors_ > 0 ? bytesOf(colorBits) : 0;
        const bool hasAlpha = kind_ == kGray ? pixelBytes_ == 2 && (byte(17) & 0x0f) : ownBits == 32;
        info_.channels = defaultChannels((kind_ == kGray ? 1 : 3) + hasAlpha);
        if (kind_ == kGray && bits > 16) throw Error("a gray pixel has {} bits, expected 8 or 16", bits);
        if (kind_ == kColor && bits < 15) throw Error("a color has {} bits, expected 15 to 32", bits);
        if (kind_ == kPalette && bits > 16) throw Error("an index has {} bits, expected 8 or 16", bits);
        readBytes(stream, byte(0));  // a comment
    }

    std::vector<float> readPixels() override {
        palette_ = readBytes(stream_, static_cast<size_t>(colors_) * colorBytes_);
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        const size_t channels = info_.channels.size();
        std::vector<uint8_t> values(width * height * channels);
        for (size_t i = 0; i < height; ++i) {
            uint8_t* row = &values[(isTopDown_ ? i : height - 1 - i) * width * channels];
            for (size_t j = 0; j < width; ++j) {
                const std::array<uint8_t, 4> pixel = decode(nextPixel());
                std::copy_n(pixel.begin(), channels, row + (isMirrored_ ? width - 1 - j : j) * channels);
            }
        }
        return scaledToOne(std::span<const uint8_t>(values));
    }

  private:
    enum Kind { kPalette = 1, kColor = 2, kGray = 3 };
    using Pixel = std::array<uint8_t, 4>;

    static size_t bytesOf(int bits) {
        if (bits != 8 && bits != 15 && bits != 16 && bits != 24 && bits != 32)
            throw Error("found {} bits, expected 8, 15, 16, 24 or 32", bits);
        return static_cast<size_t>(bits + 7) / 8;
    }

    /// As it is in the file.
    Pixel nextPixel() {
        if (!isRuns_) return readPixel();
        if (left_ == 0) {
            const uint8_t code = readByte(stream_);
            left_ = (code & 127) + 1;
            isRepeated_ = code & 128;
            if (isRepeated_) repeated_ = readPixel();
        }
        --left_;
        return isRepeated_ ? repeated_ : readPixel();
    }
    Pixel readPixel() {
        Pixel pixel{};
        // GCC 14 does not know that there are four bytes at most.
        for (size_t i = 0; i < std::min(pixelBytes_, pixel.size()); ++i) pixel[i] = readByte(stream_);
        return pixel;
    }

    Pixel decode(const Pixel& stored) const {
        if (kind_ == kGray) return stored;
        if (kind_ == kColor) return color(stored.data(), pixelBytes_);
        const int index = stored[0] + 256 * stored[1] - firstColor_;
        if (index < 0 || index >= colors_)
            throw Error("a pixel has color {}, but the palette has {} to {}", index + firstColor_,
                        firstColor_, firstColor_ + colors_ - 1);
        return color(
            reinterpret_cast<const uint8_t*>(palette_.data()) + static_cast<size_t>(index) * colorBytes_,
            colorBytes_);
    }
    /// Blue, green, red and perhaps alpha; or 5 bits of each.
    static Pixel color(const uint8_t* bytes, size_t size) {
        if (size == 4) return {bytes[2], bytes[1], bytes[0], bytes[3]};
        if (size == 3) return {bytes[2], bytes[1], bytes[0], 255};
        if (size == 1) return {bytes[0], bytes[0], bytes[0], 255};
        const unsigned bits = bytes[0] + 256u * bytes[1];
        const auto widened = [&](unsigned shift) {
            const unsigned five = bits >> shift & 31;
            return static_cast<uint8_t>(five << 3 | five >> 2);
        };
        return {widened(10), widened(5), widened(0), 255};
    }

    std::istream& stream_;
    int kind_ = 0, firstColor_ = 0, colors_ = 0, left_ = 0;
    bool isRuns_ = false, isMirrored_ = false, isTopDown_ = false, isRepeated_ = false;
    size_t pixelBytes_ = 1, colorBytes_ = 0;
    std::string palette_;
    Pixel repeated_{};
};

}  // namespace

std::unique_ptr<ImageDecoder> openTga(std::istream& stream) { return std::make_unique<TgaDecoder>(stream); }

}  // namespace metrolux::core
