/// Radiance's pictures: 8-bit mantissas with a common exponent (G. Ward, "Real Pixels", Graphics Gems II).

#include "base/error.h"
#include "image/formats/decoder.h"

#include <array>
#include <cmath>
#include <istream>
#include <sstream>

namespace metrolux::core {
namespace {

using Rgbe = std::array<uint8_t, 4>;

class HdrDecoder final : public ImageDecoder {
  public:
    explicit HdrDecoder(std::istream& stream) : stream_(stream) {
        info_.format = "hdr";
        info_.channels = defaultChannels(3);
        isFloat_ = true;
        valueBytes_ = 4;
        std::string line = readLine();
        while (!(line = readLine()).empty())
            if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe")
                throw Error("found '{}', expected FORMAT=32-bit_rle_rgbe", line);
        // Height with the direction of its lines, then width with that of the pixels.
        std::istringstream size(readLine());
        std::string vertical, horizontal;
        if (!(size >> vertical >> info_.height >> horizontal >> info_.width) ||
            (vertical != "-Y" && vertical != "+Y") || (horizontal != "+X" && horizontal != "-X"))
            throw Error("found '{}', expected a size like -Y 512 +X 768", size.str());
        isBottomUp_ = vertical == "+Y";
        isMirrored_ = horizontal == "-X";
    }

    std::vector<float> readPixels() override {
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        std::vector<float> pixels(width * height * 3);
        std::vector<Rgbe> row(width);
        for (size_t i = 0; i < height; ++i) {
            readRow(row);
            float* out = &pixels[(isBottomUp_ ? height - 1 - i : i) * width * 3];
            for (size_t x = 0; x < width; ++x) {
                const Rgbe& p = row[isMirrored_ ? width - 1 - x : x];
                const float scale = p[3] == 0 ? 0.0f : std::ldexp(1.0f, p[3] - (128 + 8));
                for (size_t c = 0; c < 3; ++c) *out++ = static_cast<float>(p[c]) * scale;
            }
        }
        return pixels;
    }

  private:
    std::string readLine() {
        constexpr size_t kLongest = 4096;
        std::string line;
        for (int c; (c = stream_.get()) != '\n'; line.push_back(static_cast<char>(c)))
            if (c == std::char_traits<char>::eof() || line.size() > kLongest)
                throw Error("its header does not end");
        return line;
    }
    Rgbe readPixel() {
        Rgbe pixel;
        for (uint8_t& value : pixel) value = readByte(stream_);
        return pixel;
    }

    void readRow(std::vector<Rgbe>& row) {
        constexpr size_t kShortestRuns = 8, kLongestRuns = 0x7fff;
        const Rgbe first = readPixel();
        if (row.size() < kShortestRuns || row.size() > kLongestRuns || first[0] != 2 || first[1] != 2 ||
            first[2] >= 128)
            return readPlainRow(first, row);
        if (size_t{first[2]} * 256 + first[3] != row.size())
            throw Error("a row has {} pixels, expected {}", first[2] * 256 + first[3], row.size());
        for (size_t c = 0; c < 4; ++c) readComponent(row, c);
    }

    /// One of the four bytes of all pixels of a row. A count above 128 is that of a run of one value.
    void readComponent(std::vector<Rgbe>& row, size_t c) {
        for (size_t x = 0; x < row.size();) {
            const uint8_t code = readByte(stream_);
            const size_t count = code > 128 ? code - 128u : code;
            if (count == 0 || count > row.size() - x) throw Error("a run is longer than its row");
            const uint8_t value = code > 128 ? readByte(stream_) : uint8_t{0};
            for (size_t i = 0; i < count; ++i) row[x++][c] = code > 128 ? value : readByte(stream_);
        }
    }

    /// Whole pixels; (1, 1, 1, n) repeats the one before n times, with 8 bits more after each such.
    void readPlainRow(Rgbe pixel, std::vector<Rgbe>& row) {
        int shift = 0;
        for (size_t x = 0; x < row.size();) {
            if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1 && x > 0 && shift < 32) {
                const size_t count = size_t{pixel[3]} << shift;
                if (count > row.size() - x) throw Error("a run is longer than its row");
                const Rgbe last = row[x - 1];
                for (size_t i = 0; i < count; ++i) row[x++] = last;
                shift += 8;
            } else {
                row[x++] = pixel;
                shift = 0;
            }
            if (x < row.size()) pixel = readPixel();
        }
    }

    std::istream& stream_;
    bool isBottomUp_ = false, isMirrored_ = false;
};

}  // namespace

std::unique_ptr<ImageDecoder> openHdr(std::istream& stream) { return std::make_unique<HdrDecoder>(stream); }

}  // namespace metrolux::core
