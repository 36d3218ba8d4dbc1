/// TIFF, with libtiff. Gray and color of 8, 16 and 32 bits are read as they are; libtiff makes 8-bit RGBA of
/// everything else (palettes, bits, inks, JPEG inside).

#include "base/error.h"
#include "image/formats/decoder.h"

#include <Imath/half.h>

#include <cstdarg>
#include <cstring>
#include <istream>
#include <tiffio.h>

namespace metrolux::core {
namespace {

class TiffDecoder final : public ImageDecoder {
  public:
    explicit TiffDecoder(std::istream& stream) : stream_(stream) {
        info_.format = "tiff";
        using Options = std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)>;
        const Options options(TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
        if (!options) throw std::bad_alloc();
        TIFFOpenOptionsSetErrorHandlerExtR(options.get(), &onError, this);
        TIFFOpenOptionsSetWarningHandlerExtR(options.get(), &onWarning, this);
        file_.reset(TIFFClientOpenExt("image", "rm", this, &read, &write, &seek, &close, &size, nullptr,
                                      nullptr, options.get()));
        if (!file_) fail("it is no TIFF");
        readHeader();
    }

    std::vector<float> readPixels() override {
        if (isConverted_) return readConverted();
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        const size_t channels = info_.channels.size();
        std::vector<float> pixels(width * height * channels);
        if (TIFFIsTiled(file_.get()))
            readTiles(pixels);
        else
            readStrips(pixels);
        return pixels;
    }

  private:
    static TiffDecoder& self(void* handle) { return *static_cast<TiffDecoder*>(handle); }
    static tmsize_t read(thandle_t handle, void* bytes, tmsize_t count) {
        std::istream& stream = self(handle).stream_;
        stream.clear();
        stream.read(static_cast<char*>(bytes), count);
        return static_cast<tmsize_t>(stream.gcount());
    }
    static tmsize_t write(thandle_t, void*, tmsize_t) { return 0; }
    static toff_t seek(thandle_t handle, toff_t offset, int whence) {
        std::istream& stream = self(handle).stream_;
        stream.clear();
        stream.seekg(static_cast<std::streamoff>(offset), whence == SEEK_SET   ? std::ios::beg
                                                          : whence == SEEK_CUR ? std::ios::cur
                                                                               : std::ios::end);
        return static_cast<toff_t>(static_cast<std::streamoff>(stream.tellg()));
    }
    static toff_t size(thandle_t handle) {
        const toff_t here = seek(handle, 0, SEEK_CUR), end = seek(handle, 0, SEEK_END);
        seek(handle, here, SEEK_SET);
        return end;
    }
    static int close(thandle_t) { return 0; }
    static int onError(TIFF*, void* user, const char*, const char* format, va_list arguments) {
        std::vsnprintf(self(user).message_, sizeof self(user).message_, format, arguments);
        return 1;
    }
    static int onWarning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

    [[noreturn]] void fail(const char* otherwise) const {
        throw Error(std::string(message_[0] ? message_ : otherwise));
    }

    template <class T>
    T field(ttag_t tag) const {
        T value{};
        TIFFGetFieldDefaulted(file_.get(), tag, &value);
        return value;
    }

    void readHeader() {
        const uint32_t width = field<uint32_t>(TIFFTAG_IMAGEWIDTH),
                       height = field<uint32_t>(TIFFTAG_IMAGELENGTH);
        if (width > uint32_t{kLargestSide} || height > uint32_t{kLargestSide})
            throw Error("it has {}x{} pixels, expected at most {} a side", width, height, kLargestSide);
        info_.width = static_cast<int>(width);
        info_.height = static_cast<int>(height);
        if (field<uint32_t>(TIFFTAG_IMAGEDEPTH) > 1) throw Error("it is a volume");
        bits_ = field<uint16_t>(TIFFTAG_BITSPERSAMPLE);
        format_ = field<uint16_t>(TIFFTAG_SAMPLEFORMAT);
        const uint16_t photometric = field<uint16_t>(TIFFTAG_PHOTOMETRIC);
        const uint16_t channels = field<uint16_t>(TIFFTAG_SAMPLESPERPIXEL);
        isPlanar_ = field<uint16_t>(TIFFTAG_PLANARCONFIG) == PLANARCONFIG_SEPARATE;
        const bool isPlain = photometric == PHOTOMETRIC_MINISBLACK || photometric == PHOTOMETRIC_RGB;
        const bool isInteger = format_ == SAMPLEFORMAT_UINT && (bits_ == 8 || bits_ == 16 || bits_ == 32);
        isFloat_ = format_ == SAMPLEFORMAT_IEEEFP && (bits_ == 16 || bits_ == 32 || bits_ == 64);
        isConverted_ = !isPlain || !(isInteger || isFloat_);
        if (isConverted_) {
            char reason[1024] = "";
            if (format_ == SAMPLEFORMAT_IEEEFP || !TIFFRGBAImageOK(file_.get(), reason))
                throw Error("{} bits of format {} are not read: {}", bits_, format_, reason);
            const bool isGray = photometric <= PHOTOMETRIC_MINISBLACK;
            info_.channels = defaultChannels((isGray ? 1 : 3) + !alphas().empty());
            return;
        }
        valueBytes_ = bits_ / 8;
        nameChannels(channels, photometric == PHOTOMETRIC_RGB ? 3 : 1);
    }

    void nameChannels(int count, int colors) {
        if (count < colors) throw Error("it has {} channels, expected {}", count, colors);
        info_.channels = defaultChannels(colors);
        const std::vector<bool> isAlpha = alphas();
        for (int c = colors; c < count; ++c) {
            const auto i = static_cast<size_t>(c - colors);
            info_.channels.push_back(i < isAlpha.size() && isAlpha[i] ? "A" : fmt::format("channel{}", c));
        }
    }
    /// Whether each channel beyond the colors is alpha.
    std::vector<bool> alphas() const {
        uint16_t count = 0;
        const uint16_t* kinds = nullptr;
        TIFFGetFieldDefaulted(file_.get(), TIFFTAG_EXTRASAMPLES, &count, &kinds);
        std::vector<bool> result;
        for (uint16_t i = 0; i < count; ++i) result.push_back(kinds[i] != EXTRASAMPLE_UNSPECIFIED);
        return result;
    }

    /// One value at `i` of a buffer of them.
    float value(const uint8_t* buffer, size_t i) const {
        const auto load = [&]<class T>(T value) {
            std::memcpy(&value, buffer + i * sizeof value, sizeof value);
            return value;
        };
        if (isFloat_ && bits_ == 16) {
            half h;
            h.setBits(load(uint16_t{}));
            return h;
        }
        if (isFloat_) return bits_ == 32 ? load(float{}) : static_cast<float>(load(double{}));
        if (bits_ == 8) return static_cast<float>(buffer[i]) * (1.0f / 255.0f);
        if (bits_ == 16) return static_cast<float>(load(uint16_t{})) * (1.0f / 65535.0f);
        return static_cast<float>(load(uint32_t{})) * (1.0f / 4294967295.0f);
    }

    /// Puts a block of pixels at (x, y), cut off where the image ends. A planar block has channel `plane`.
    void place(const std::vector<uint8_t>& block, size_t x, size_t y, size_t blockWidth, size_t blockHeight,
               size_t plane, std::vector<float>& pixels) const {
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        const size_t channels = info_.channels.size(), inBlock = isPlanar_ ? 1 : channels;
        for (size_t j = 0; j < blockHeight && y + j < height; ++j)
            for (size_t i = 0; i < blockWidth && x + i < width; ++i)
                for (size_t c = 0; c < inBlock; ++c)
                    pixels[((y + j) * width + x + i) * channels + plane + c] =
                        value(block.data(), (j * blockWidth + i) * inBlock + c);
    }

    void readStrips(std::vector<float>& pixels) {
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        const size_t planes = isPlanar_ ? info_.channels.size() : 1,
                     inBlock = isPlanar_ ? 1 : info_.channels.size();
        const size_t rows = std::min<size_t>(std::max(1u, field<uint32_t>(TIFFTAG_ROWSPERSTRIP)), height);
        std::vector<uint8_t> block(rows * width * inBlock * static_cast<size_t>(valueBytes_));
        for (size_t plane = 0; plane < planes; ++plane)
            for (size_t y = 0; y < height; y += rows) {
                const uint32_t strip =
                    TIFFComputeStrip(file_.get(), static_cast<uint32_t>(y), static_cast<uint16_t>(plane));
                const size_t lines = std::min(rows, height - y);
                const auto bytes =
                    static_cast<tmsize_t>(lines * width * inBlock * static_cast<size_t>(valueBytes_));
                if (TIFFReadEncodedStrip(file_.get(), strip, block.data(), bytes) != bytes)
                    fail("the file ends too early");
                place(block, 0, y, width, lines, plane, pixels);
            }
    }

    void readTiles(std::vector<float>& pixels) {
        const size_t width = static_cast<size_t>(info_.width), height = static_cast<size_t>(info_.height);
        const size_t planes = isPlanar_ ? info_.channels.size() : 1,
                     inBlock = isPlanar_ ? 1 : info_.channels.size();
        const size_t tileWidth = field<uint32_t>(TIFFTAG_TILEWIDTH),
                     tileHeight = field<uint32_t>(TIFFTAG_TILELENGTH);
        if (tileWidth == 0 || tileHeight == 0 || tileWidth > size_t{kLargestSide} ||
            tileHeight > size_t{kLargestSide} ||
            tileWidth * tileHeight > 4 * std::max<size_t>(width * height, 1 << 16))
            throw Error("its tiles have {}x{} pixels", tileWidth, tileHeight);
        std::vector<uint8_t> block(tileWidth * tileHeight * inBlock * static_cast<size_t>(valueBytes_));
        for (size_t plane = 0; plane < planes; ++plane)
            for (size_t y = 0; y < height; y += tileHeight)
                for (size_t x = 0; x < width; x += tileWidth) {
                    const auto bytes = static_cast<tmsize_t>(block.size());
                    const uint32_t tile =
                        TIFFComputeTile(file_.get(), static_cast<uint32_t>(x), static_cast<uint32_t>(y), 0,
                                        static_cast<uint16_t>(plane));
                    if (TIFFReadEncodedTile(file_.get(), tile, block.data(), bytes) != bytes)
                        fail("the file ends too early");
                    place(block, x, y, tileWidth, tileHeight, plane, pixels);
                }
    }

    std::vector<float> readConverted() {
        const size_t count = static_cast<size_t>(info_.width) * static_cast<size_t>(info_.height);
        std::vector<uint32_t> packed(count);
        if (!TIFFReadRGBAImageOriented(file_.get(), static_cast<uint32_t>(info_.width),
                                       static_cast<uint32_t>(info_.height), packed.data(),
                                       ORIENTATION_TOPLEFT, 1))
            fail("the file ends too early");
        const size_t channels = info_.channels.size(), colors = channels < 3 ? 1 : 3;
        std::vector<uint8_t> values;
        values.reserve(channels * count);
        for (const uint32_t pixel : packed)
            for (size_t c = 0; c < channels; ++c)
                values.push_back(static_cast<uint8_t>(pixel >> 8 * (c < colors ? c : 3)));
        return scaledToOne(std::span<const uint8_t>(values));
    }

    std::istream& stream_;
    char message_[256] = "";
    std::unique_ptr<TIFF, decltype(&TIFFClose)> file_{nullptr, &TIFFClose};
    uint16_t bits_ = 8, format_ = SAMPLEFORMAT_UINT;
    bool isPlanar_ = false, isConverted_ = false;
};

}  // namespace

std::unique_ptr<ImageDecoder> openTiff(std::istream& stream) { return std::make_unique<TiffDecoder>(stream); }

}  // namespace metrolux::core
