/// PNG, with libpng.

#include "base/error.h"
#include "image/formats/decoder.h"
#include "image/formats/encoder.h"

#include <bit>
#include <csetjmp>
#include <cstring>
#include <istream>
#include <png.h>

namespace metrolux::core {
namespace {

/// libpng reports an error by a jump, over frames that may therefore hold nothing that wants a destructor.
struct PngErrors {
    char message[256] = "";

    static void fail(png_structp png, png_const_charp text) {
        auto* self = static_cast<PngErrors*>(png_get_error_ptr(png));
        std::strncpy(self->message, text, sizeof self->message - 1);
        png_longjmp(png, 1);
    }
    static void ignore(png_structp, png_const_charp) {}

    /// Runs `action`, which has only trivial local variables, and throws what libpng reports.
    template <class Action>
    void run(png_structp png, const Action& action) {
        if (setjmp(png_jmpbuf(png))) throw Error(std::string(message));
        action();
    }
};

class PngDecoder final : public ImageDecoder {
  public:
    explicit PngDecoder(std::istream& stream) : stream_(stream) {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &errors_, &PngErrors::fail, &PngErrors::ignore);
        if (png_) header_ = png_create_info_struct(png_);
        if (!header_) {
            png_destroy_read_struct(&png_, &header_, nullptr);
            throw std::bad_alloc();
        }
        try {
            readHeader();
        } catch (...) {
            png_destroy_read_struct(&png_, &header_, nullptr);
            throw;
        }
    }
    ~PngDecoder() override { png_destroy_read_struct(&png_, &header_, nullptr); }
    PngDecoder(const PngDecoder&) = delete;
    PngDecoder& operator=(const PngDecoder&) = delete;

    std::vector<float> readPixels() override {
        const size_t height = static_cast<size_t>(info_.height), rowBytes = png_get_rowbytes(png_, header_);
        // Words, for 16-bit images want to be aligned.
        std::vector<uint16_t> words((rowBytes * height + 1) / 2);
        auto* bytes = reinterpret_cast<uint8_t*>(words.data());
        std::vector<png_bytep> rows(height);
        for (size_t y = 0; y < height; ++y) rows[y] = bytes + y * rowBytes;
        errors_.run(png_, [&] { png_read_image(png_, rows.data()); });
        if (valueBytes_ == 2)
            return scaledToOne(std::span<const uint16_t>(words.data(), rowBytes * height / 2));
        return scaledToOne(std::span<const uint8_t>(bytes, rowBytes * height));
    }

  private:
    static void read(png_structp png, png_bytep bytes, size_t count) {
        auto& stream = *static_cast<std::istream*>(png_get_io_ptr(png));
        stream.read(reinterpret_cast<char*>(bytes), static_cast<std::streamsize>(count));
        if (static_cast<size_t>(stream.gcount()) != count) png_error(png, "the file ends too early");
    }

    void readHeader() {
        errors_.run(png_, [&] {
            png_set_read_fn(png_, &stream_, &read);
            png_set_user_limits(png_, kLargestSide, kLargestSide);
            png_read_info(png_, header_);
            png_set_expand(png_);  // palettes, small integers and transparent colors
            if (std::endian::native == std::endian::little) png_set_swap(png_);
            png_set_interlace_handling(png_);
            png_read_update_info(png_, header_);
        });
        info_.format = "png";
        info_.width = static_cast<int>(png_get_image_width(png_, header_));
        info_.height = static_cast<int>(png_get_image_height(png_, header_));
        info_.channels = defaultChannels(png_get_channels(png_, header_));
        valueBytes_ = png_get_bit_depth(png_, header_) == 16 ? 2 : 1;
        png_textp texts = nullptr;
        const int count = png_get_text(png_, header_, &texts, nullptr);
        for (int i = 0; i < count; ++i)
            if (texts[i].text) info_.metadata.emplace_back(texts[i].key, std::string(texts[i].text));
    }

    std::istream& stream_;
    PngErrors errors_;
    png_structp png_ = nullptr;
    png_infop header_ = nullptr;
};

/// What libpng writes. Memory that runs out in `append` may not be thrown through its frames.
struct PngOutput {
    std::string bytes;
    bool outOfMemory = false;

    static void append(png_structp png, png_bytep data, size_t count) {
        auto* self = static_cast<PngOutput*>(png_get_io_ptr(png));
        if (!self->tryAppend(data, count)) png_error(png, "out of memory");
    }
    static void flush(png_structp) {}

  private:
    bool tryAppend(png_bytep data, size_t count) {
        try {
            bytes.append(reinterpret_cast<const char*>(data), count);
        } catch (const std::bad_alloc&) {
            outOfMemory = true;
        }
        return !outOfMemory;
    }
};

class PngEncoder {
  public:
    PngEncoder() {
        png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &errors_, &PngErrors::fail, &PngErrors::ignore);
        if (png_) header_ = png_create_info_struct(png_);
        if (!header_) {
            png_destroy_write_struct(&png_, &header_);
            throw std::bad_alloc();
        }
    }
    ~PngEncoder() { png_destroy_write_struct(&png_, &header_); }
    PngEncoder(const PngEncoder&) = delete;
    PngEncoder& operator=(const PngEncoder&) = delete;

    std::string encode(int width, int height, const uint8_t* rgb, std::vector<png_text>& texts) {
        PngOutput output;
        try {
            errors_.run(png_, [&] { write(width, height, rgb, texts, output); });
        } catch (const Error&) {
            if (output.outOfMemory) throw std::bad_alloc();
            throw;
        }
        return std::move(output.bytes);
    }

  private:
    void write(int width, int height, const uint8_t* rgb, std::vector<png_text>& texts, PngOutput& output) {
        png_set_write_fn(png_, &output, &PngOutput::append, &PngOutput::flush);
        png_set_IHDR(png_, header_, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
                     PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                     PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB_gAMA_and_cHRM(png_, header_, PNG_sRGB_INTENT_ABSOLUTE);
        png_set_text(png_, header_, texts.data(), static_cast<int>(texts.size()));
        png_write_info(png_, header_);
        for (int y = 0; y < height; ++y)
            png_write_row(png_, rgb + size_t{3} * static_cast<size_t>(width) * static_cast<size_t>(y));
        png_write_end(png_, header_);
    }

    PngErrors errors_;
    png_structp png_ = nullptr;
    png_infop header_ = nullptr;
};

}  // namespace

std::unique_ptr<ImageDecoder> openPng(std::istream& stream) { return std::make_unique<PngDecoder>(stream); }

std::string encodePngBytes(int width, int height, std::span<const uint8_t> rgb, const Metadata& metadata) {
    std::vector<png_text> texts;
    for (const auto& [name, value] : metadata) {
        const auto* content = std::get_if<std::string>(&value);
        if (!content) continue;
        png_text text{};
        text.compression = PNG_TEXT_COMPRESSION_NONE;
        text.key = const_cast<char*>(name.c_str());
        text.text = const_cast<char*>(content->c_str());
        text.text_length = content->size();
        texts.push_back(text);
    }
    return PngEncoder().encode(width, height, rgb.data(), texts);
}

}  // namespace metrolux::core
