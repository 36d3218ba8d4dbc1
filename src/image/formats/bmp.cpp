/// Windows and OS/2 bitmaps: palettes, runs, and colors of 16, 24 and 32 bits.

#include "base/error.h"
#include "image/formats/decoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <istream>

namespace metrolux::core {
namespace {

using Color = std::array<uint8_t, 3>;

class BmpDecoder final : public ImageDecoder {
  public:
    explicit BmpDecoder(std::istream& stream) : stream_(stream) {
        info_.format = "bmp";
        const std::string start = readBytes(stream, 18);
        dataOffset_ = little(start, 10, 4);
        const uint32_t headerSize = little(start, 14, 4);
        if (headerSize != 12 && (headerSize < 40 || headerSize > 124))
            throw Error("its header has {} bytes, expected 12 or 40 to 124", headerSize);
        const std::string header = readBytes(stream, headerSize - 4);
        const bool isOld = headerSize == 12;
        const auto signedValue = [&](size_t at) { return static_cast<int32_t>(little(header, at, 4)); };
        info_.width = isOld ? static_cast<int>(little(header, 0, 2)) : signedValue(0);
        const int height = isOld ? static_cast<int>(little(header, 2, 2)) : signedValue(4);
        isTopDown_ = height < 0;
        info_.height = height == INT32_MIN ? 0 : std::abs(height);
        bits_ = little(header, isOld ? 6 : 10, 2);
        compression_ = isOld ? kPlain : little(header, 12, 4);
        if (bits_ != 1 && bits_ != 4 && bits_ != 8 && bits_ != 16 && bits_ != 24 && bits_ != 32)
            throw Error("a pixel has {} bits, expected 1, 4, 8, 16, 24 or 32", bits_);
        const bool isRuns = (compression_ == kRuns8 && bits_ == 8) || (compression_ == kRuns4 && bits_ == 4);
        const bool isMasks = compression_ == kMasks && bits_ >= 16;
        if (compression_ != kPlain && !isRuns && !isMasks)
            throw Error("its compression is {} with {} bits, expected none, runs or masks", compression_,
                        bits_);
        if (isMasks) readMasks(header);
        if (bits_ <= 8) readPalette(isOld ? 3 : 4, isOld ? 0 : little(header, 28, 4));
        const bool isGray = bits_ == 8 && std::all_of(palette_.begin(), palette_.end(), [](const Color& c) {
                                return c[0] == c[1] && c[1] == c[2];
                            });
        info_.channels = defaultChannels(isGray ? 1 : bits_ == 32 ? 4 : 3);
    }

    std::vector<float> readPixels() override {
        stream_.clear();
        stream_.seekg(static_cast<std::streamoff>(dataOffset_));
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        const size_t row = width * info_.channels.size();
        std::vector<uint8_t> values(row * height);
        const bool isRuns = compression_ == kRuns8 || compression_ == kRuns4;
        const std::vector<uint8_t> indices = isRuns ? readRuns() : std::vector<uint8_t>{};
        for (size_t i = 0; i < height; ++i) {
            uint8_t* out = &values[(isTopDown_ ? i : height - 1 - i) * row];
            if (isRuns) {
                for (size_t x = 0; x < width; ++x) out = put(palette(indices[i * width + x]), out);
            } else {
                decodeRow(readBytes(stream_, (width * bits_ + 31) / 32 * 4), out);
            }
        }
        return scaledToOne(std::span<const uint8_t>(values));
    }

  private:
    enum Compression : uint32_t { kPlain = 0, kRuns8 = 1, kRuns4 = 2, kMasks = 3 };

    static uint32_t little(const std::string& bytes, size_t at, size_t size) {
        if (at + size > bytes.size()) return 0;
        uint32_t value = 0;
        for (size_t i = 0; i < size; ++i)
            value |= uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
        return value;
    }

    /// They are in the newer headers, and after the older one.
    void readMasks(const std::string& header) {
        const std::string bytes = header.size() >= 48 ? header.substr(36, 12) : readBytes(stream_, 12);
        for (size_t c = 0; c < 3; ++c) masks_[c] = little(bytes, 4 * c, 4);
        for (const uint32_t mask : masks_)
            if (mask == 0) throw Error("a color has no bits");
    }
    void readPalette(size_t colorBytes, uint32_t claimed) {
        const uint32_t most = 1u << bits_;
        const uint32_t count = claimed == 0 ? most : claimed;
        if (count > most) throw Error("its palette has {} colors, expected at most {}", count, most);
        const std::string bytes = readBytes(stream_, count * colorBytes);
        for (size_t i = 0; i < count; ++i) {
            const auto at = [&](size_t c) { return static_cast<uint8_t>(bytes[i * colorBytes + c]); };
            palette_.push_back({at(2), at(1), at(0)});
        }
    }
    const Color& palette(size_t index) const {
        if (index >= palette_.size())
            throw Error("a pixel has color {}, but the palette has {}", index, palette_.size());
        return palette_[index];
    }
    uint8_t* put(const Color& color, uint8_t* out) const {
        return std::copy_n(color.begin(), std::min<size_t>(info_.channels.size(), 3), out);
    }

    void decodeRow(const std::string& bytes, uint8_t* out) const {
        const size_t width = static_cast<size_t>(info_.width);
        for (size_t x = 0; x < width; ++x) {
            if (bits_ <= 8) {
                const size_t bit = x * bits_;
                const auto byte = static_cast<unsigned char>(bytes[bit / 8]);
                out = put(palette(byte >> (8 - bits_ - bit % 8) & ((1u << bits_) - 1)), out);
                continue;
            }
            const uint32_t pixel = little(bytes, x * bits_ / 8, bits_ / 8);
            if (bits_ == 16 || compression_ == kMasks) {
                for (const uint32_t mask : masks_) *out++ = underMask(pixel, mask);
            } else {
                for (const int shift : {16, 8, 0}) *out++ = static_cast<uint8_t>(pixel >> shift);
            }
            if (bits_ == 32) *out++ = static_cast<uint8_t>(pixel >> 24);
        }
    }
    /// The bits of a mask, repeated until they are 8.
    static uint8_t underMask(uint32_t pixel, uint32_t mask) {
        const uint32_t value = (pixel & mask) >> std::countr_zero(mask);
        const int bits = std::popcount(mask);
        uint32_t result = 0;
        for (int shift = 8 - bits; shift > -bits; shift -= bits)
            result |= shift >= 0 ? value << shift : value >> -shift;
        return static_cast<uint8_t>(result);
    }

    /// Runs of indices, and marks: the end of a line, the end, a step to another pixel, pixels one by one.
    std::vector<uint8_t> readRuns() {
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        std::vector<uint8_t> indices(width * height);
        size_t x = 0, y = 0;
        const auto put = [&](uint8_t value) {
            if (y >= height) throw Error("a run leaves the image");
            if (x < width) indices[y * width + x] = value;
            ++x;
        };
        const auto half = [&](uint8_t byte, size_t i) {
            if (bits_ == 8) return byte;
            return static_cast<uint8_t>(i % 2 == 0 ? byte >> 4 : byte & 15);
        };
        while (true) {
            const std::string pair = readBytes(stream_, 2);
            const auto count = static_cast<uint8_t>(pair[0]), value = static_cast<uint8_t>(pair[1]);
            if (count > 0) {
                for (size_t i = 0; i < count; ++i) put(half(value, i));
            } else if (value == 0) {
                x = 0;
                ++y;
            } else if (value == 1) {
                return indices;
            } else if (value == 2) {
                const std::string step = readBytes(stream_, 2);
                x += static_cast<uint8_t>(step[0]);
                y += static_cast<uint8_t>(step[1]);
            } else {
                const size_t bytes = (value * bits_ / 8 + (value * bits_ % 8 != 0) + 1) / 2 * 2;
                const std::string plain = readBytes(stream_, bytes);
                for (size_t i = 0; i < value; ++i) put(half(static_cast<uint8_t>(plain[i * bits_ / 8]), i));
            }
        }
    }

    std::istream& stream_;
    uint32_t dataOffset_ = 0, bits_ = 0, compression_ = kPlain;
    std::array<uint32_t, 3> masks_{0x7c00, 0x03e0, 0x001f};
    bool isTopDown_ = false;
    std::vector<Color> palette_;
};

}  // namespace

std::unique_ptr<ImageDecoder> openBmp(std::istream& stream) { return std::make_unique<BmpDecoder>(stream); }

}  // namespace metrolux::core
