/// The portable anymaps of Netpbm, P1 to P6, and PFM, whose values are floats.

#include "base/error.h"
#include "image/formats/decoder.h"

#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <istream>

namespace metrolux::core {
namespace {

class PnmDecoder final : public ImageDecoder {
  public:
    explicit PnmDecoder(std::istream& stream) : stream_(stream) {
        info_.format = "pnm";
        kind_ = readBytes(stream, 2)[1];
        info_.channels = defaultChannels(kind_ == '3' || kind_ == '6' || kind_ == 'F' ? 3 : 1);
        info_.width = readInteger();
        info_.height = readInteger();
        if (isFloatKind()) {
            isFloat_ = true;
            valueBytes_ = 4;
            scale_ = readScale();
        } else if (!isBitmap()) {
            largest_ = readInteger();
            if (largest_ < 1 || largest_ > 65535)
                throw Error("its largest value is {}, expected 1 to 65535", largest_);
            valueBytes_ = largest_ > 255 ? 2 : 1;
        }
    }

    std::vector<float> readPixels() override {
        if (isFloatKind()) return readFloats();
        const size_t count =
            info_.channels.size() * static_cast<size_t>(info_.width) * static_cast<size_t>(info_.height);
        if (kind_ == '4') return readBits();
        std::vector<uint16_t> values;
        values.reserve(count);
        if (kind_ < '4') {
            while (values.size() < count) values.push_back(isBitmap() ? readBit() : checked(readInteger()));
        } else {
            const std::string bytes = readBytes(stream_, count * static_cast<size_t>(valueBytes_));
            const auto at = [&](size_t i) { return static_cast<unsigned char>(bytes[i]); };
            for (size_t i = 0; i < count; ++i)
                values.push_back(valueBytes_ == 1 ? checked(at(i))
                                                  : checked(at(2 * i) * 256 + at(2 * i + 1)));
        }
        return scaledFromLargest(values);
    }

  private:
    bool isFloatKind() const { return kind_ == 'F' || kind_ == 'f'; }
    bool isBitmap() const { return kind_ == '1' || kind_ == '4'; }

    /// After blanks and comments; one blank after the word is taken too.
    std::string readWord() {
        int c = stream_.get();
        while (c == '#' || (c >= 0 && std::isspace(c))) {
            if (c == '#')
                while (c >= 0 && c != '\n') c = stream_.get();
            c = stream_.get();
        }
        constexpr size_t kLongest = 64;
        std::string word;
        for (; c >= 0 && !std::isspace(c) && word.size() < kLongest; c = stream_.get())
            word.push_back(static_cast<char>(c));
        if (word.empty()) throw Error("the file ends too early");
        return word;
    }
    int readInteger() {
        const std::string word = readWord();
        int value = 0;
        if (!parse(word, value)) throw Error("found '{}', expected an integer", word);
        return value;
    }
    float readScale() {
        const std::string word = readWord();
        float value = 0;
        if (!parse(word, value) || !std::isfinite(value) || value == 0)
            throw Error("its scale is '{}', expected a number that is not 0", word);
        return value;
    }
    /// Whether the whole word is a number.
    template <class T>
    static bool parse(const std::string& word, T& value) {
        const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
        return code == std::errc{} && end == word.data() + word.size();
    }
    uint16_t checked(int value) const {
        if (value < 0 || value > largest_)
            throw Error("found the value {}, expected 0 to {}", value, largest_);
        return static_cast<uint16_t>(value);
    }
    /// Digits of a bitmap need no blanks between them; 1 is black.
    uint16_t readBit() {
        int c = stream_.get();
        while (c >= 0 && std::isspace(c)) c = stream_.get();
        if (c != '0' && c != '1') throw Error("found no digit of a bitmap where one was expected");
        return c == '0';
    }
    std::vector<float> readBits() {
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        std::vector<float> values;
        values.reserve(width * height);
        for (size_t y = 0; y < height; ++y) {
            const std::string row = readBytes(stream_, (width + 7) / 8);
            for (size_t x = 0; x < width; ++x) values.push_back(row[x / 8] >> (7 - x % 8) & 1 ? 0.0f : 1.0f);
        }
        return values;
    }
    /// In integers, to all that 8 or 16 bits can say.
    std::vector<float> scaledFromLargest(std::vector<uint16_t>& values) const {
        const uint32_t full = valueBytes_ == 2 ? 65535 : isBitmap() ? 1 : 255;
        for (uint16_t& value : values)
            value = static_cast<uint16_t>(value * full / static_cast<uint32_t>(largest_));
        if (valueBytes_ == 2) return scaledToOne(std::span<const uint16_t>(values));
        if (isBitmap()) return {values.begin(), values.end()};
        const std::vector<uint8_t> bytes(values.begin(), values.end());
        return scaledToOne(std::span<const uint8_t>(bytes));
    }
    /// Rows from the bottom; the sign of the scale says the order of bytes.
    std::vector<float> readFloats() {
        const size_t height = static_cast<size_t>(info_.height);
        const size_t row = static_cast<size_t>(info_.width) * info_.channels.size();
        const bool isSwapped = (scale_ < 0) != (std::endian::native == std::endian::little);
        std::vector<float> values(row * height);
        for (size_t y = height; y-- > 0;) {
            const std::string bytes = readBytes(stream_, row * sizeof(float));
            for (size_t i = 0; i < row; ++i) {
                uint32_t bits;
                std::memcpy(&bits, &bytes[i * sizeof bits], sizeof bits);
                if (isSwapped) bits = __builtin_bswap32(bits);
                values[y * row + i] = std::bit_cast<float>(bits) * std::abs(scale_);
            }
        }
        return values;
    }

    std::istream& stream_;
    char kind_;
    int largest_ = 1;
    float scale_ = 1;
};

}  // namespace

std::unique_ptr<ImageDecoder> openPnm(std::istream& stream) { return std::make_unique<PnmDecoder>(stream); }

}  // namespace metrolux::core
