#include "image/image_io.h"

#include "base/error.h"
#include "image/atomic_file.h"
#include "image/formats/decoder.h"
#include "image/formats/encoder.h"

#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostValues = uint64_t{1} << 29;  // 2 GiB of floats

/// No compression of the formats read here shrinks an image of more than kFreeBytes by more than this factor
/// (EXR's PIZ of a black image comes near).
constexpr uint64_t kMostExpansion = 1 << 16;
constexpr uint64_t kFreeBytes = uint64_t{64} << 20;

using Opener = std::unique_ptr<ImageDecoder> (*)(std::istream&);
struct Signature {
    std::string_view bytes;
    Opener open;
};
using namespace std::string_view_literals;
constexpr Signature kSignatures[] = {
    {"\x76\x2f\x31\x01"sv, openExr},
    {"\x89PNG\r\n\x1a\n"sv, openPng},
    {"\xff\xd8\xff"sv, openJpeg},
    {"#?"sv, openHdr},
    {"BM"sv, openBmp},
    {"II*\0"sv, openTiff},
    {"MM\0*"sv, openTiff},
    {"II+\0"sv, openTiff},
    {"MM\0+"sv, openTiff},
    {"P1"sv, openPnm},
    {"P2"sv, openPnm},
    {"P3"sv, openPnm},
    {"P4"sv, openPnm},
    {"P5"sv, openPnm},
    {"P6"sv, openPnm},
    {"PF"sv, openPnm},
    {"Pf"sv, openPnm},
};

/// What reads the bytes; null if they begin none of the formats.
Opener openerOf(std::string_view bytes) {
    for (const Signature& s : kSignatures)
        if (bytes.starts_with(s.bytes)) return s.open;
    return nullptr;
}

/// The same for a file; null if it is none of the formats.
Opener openerFor(const fs::path& file) {
    std::array<char, 16> head{};
    std::ifstream stream(file, std::ios::binary);
    stream.read(head.data(), head.size());
    const std::string_view found(head.data(), static_cast<size_t>(stream.gcount()));
    if (const Opener opener = openerOf(found)) return opener;
    std::string extension = file.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension == ".tga" && !found.empty() ? openTga : nullptr;
}

/// An image with its header read, and where its bytes come from.
class OpenImage {
  public:
    OpenImage(Opener opener, const fs::path& file, std::unique_ptr<std::istream> stream, uint64_t bytes)
        : file_(file), stream_(std::move(stream)) {
        named([&] { decoder_ = opener(*stream_); });
        checkSize(bytes);
    }

    const ImageInfo& info() const { return decoder_->info(); }
    const ImageDecoder& decoder() const { return *decoder_; }
    std::vector<float> readPixels() {
        std::vector<float> pixels;
        named([&] { pixels = decoder_->readPixels(); });
        return pixels;
    }
    /// Books the pixels to be kept, for which there must be room besides the file's.
    void book(size_t channels, MemoryBudget* memory) const {
        if (!memory) return;
        const uint64_t pixels = static_cast<uint64_t>(info().width) * static_cast<uint64_t>(info().height);
        named([&] {
            memory->take(pixels * channels * sizeof(float), "the image");
            memory->require(pixels * info().channels.size() * sizeof(float), "reading the image");
        });
    }

  private:
    /// Errors of `action` with the name of the file.
    template <class Action>
    void named(const Action& action) const {
        try {
            action();
        } catch (const Error& error) {
            throw Error("cannot read image '{}': {}", file_.string(), error.what());
        }
    }

    void checkSize(uint64_t fileBytes) const {
        const ImageInfo& image = info();
        const uint64_t channels = image.channels.size();
        const uint64_t values = static_cast<uint64_t>(std::max(image.width, 0)) *
                                static_cast<uint64_t>(std::max(image.height, 0)) * channels;
        if (values == 0) throw Error("cannot read image '{}': it has no pixels", file_.string());
        if (image.width > kLargestSide || image.height > kLargestSide || values > kMostValues)
            throw Error(
                "cannot read image '{}': {}x{} pixels of {} channels is more than the largest size of {} "
                "values",
                file_.string(), image.width, image.height, channels, kMostValues);
        const uint64_t bytes = values * static_cast<uint64_t>(decoder_->valueBytes());
        if (bytes > kFreeBytes && bytes / kMostExpansion > fileBytes)
            throw Error(
                "cannot read image '{}': {}x{} pixels of {} channels are {}, which its {} cannot hold",
                file_.string(), image.width, image.height, channels, sizeText(bytes), sizeText(fileBytes));
    }

    fs::path file_;
    std::unique_ptr<std::istream> stream_;
    std::unique_ptr<ImageDecoder> decoder_;
};

OpenImage openImage(const fs::path& file) {
    std::error_code code;
    if (!fs::exists(file, code)) throw Error("cannot read image '{}': there is no such file", file.string());
    if (fs::is_directory(file, code)) throw Error("cannot read image '{}': it is a folder", file.string());
    const Opener opener = openerFor(file);
    if (!opener)
        throw Error("cannot read image '{}': expected EXR, HDR, PNG, JPEG, BMP, TGA, TIFF, PFM or PPM",
                    file.string());
    const uint64_t size = fs::file_size(file, code);
    return {opener, file, std::make_unique<std::ifstream>(file, std::ios::binary),
            code ? ~uint64_t{0} : size};
}

/// The given channels of interleaved pixels.
std::vector<float> selectChannels(const std::vector<float>& pixels, size_t channels,
                                  const std::vector<size_t>& selection) {
    const size_t count = pixels.size() / channels;
    std::vector<float> result;
    result.reserve(count * selection.size());
    for (size_t i = 0; i < count; ++i)
        for (const size_t c : selection) result.push_back(pixels[i * channels + c]);
    return result;
}

/// Which channels of the file make the image.
std::vector<size_t> imageChannels(const std::vector<std::string>& names) {
    const auto find = [&](const char* name) {
        return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    const size_t r = find("R"), g = find("G"), b = find("B"), a = find("A"), y = find("Y"),
                 none = names.size();
    std::vector<size_t> result;
    if (r < none && g < none && b < none) {
        result = {r, g, b};
        if (a < none) result.push_back(a);
    } else if (y < none) {
        result = {y};
        if (a < none) result.push_back(a);
    } else {
        for (size_t c = 0; c < (none <= 4 ? none : 3); ++c) result.push_back(c);
    }
    return result;
}

/// Name of a channel in the file.
std::string channelName(const ImageLayer& layer, const std::string& channel) {
    if (layer.name == kAlphaLayer) return "A";
    return layer.name + (channel[0] >= '0' && channel[0] <= '9' ? "" : ".") + channel;
}

void checkImage(const ImageData& image, bool mayBeGray = false) {
    if ((image.channels != 3 && !(mayBeGray && image.channels == 1)) || image.width <= 0 ||
        image.height <= 0 ||
        image.pixels.size() != static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
                                   static_cast<size_t>(image.channels))
        throw Error("cannot write an image of {}x{} pixels, {} channels and {} values: expected 3 channels",
                    image.width, image.height, image.channels, image.pixels.size());
}

uint8_t toByte(float display) {
    return static_cast<uint8_t>(std::lround(255 * (display > 0 ? std::min(display, 1.0f) : 0.0f)));
}

ImageData decode(OpenImage file, bool raw, MemoryBudget* memory) {
    const ImageInfo& info = file.info();
    ImageData image;
    image.width = info.width;
    image.height = info.height;
    image.place = info.place;
    const std::vector<size_t> selection = imageChannels(info.channels);
    image.channels = static_cast<int>(selection.size());
    file.book(selection.size(), memory);
    image.pixels = file.readPixels();
    if (selection.size() != info.channels.size())
        image.pixels = selectChannels(image.pixels, info.channels.size(), selection);

    if (!raw && !file.decoder().isFloat()) {
        const int colors = image.channels % 2 == 0 ? image.channels - 1 : image.channels;
        // Files of 8 bits have 256 values: a table saves the power function for each texel.
        const bool bytes = file.decoder().valueBytes() == 1;
        std::array<float, 256> table;
        for (size_t v = 0; v < table.size(); ++v) table[v] = decodeSrgb(static_cast<float>(v) / 255.0f);
        for (size_t i = 0; i < image.pixels.size(); ++i) {
            if (static_cast<int>(i % static_cast<size_t>(image.channels)) >= colors) continue;
            float& value = image.pixels[i];
            value = bytes ? table[static_cast<size_t>(std::lround(value * 255.0f))] : decodeSrgb(value);
        }
    }
    return image;
}

}  // namespace

ImageData readImage(const fs::path& file, bool raw, MemoryBudget* memory) {
    return decode(openImage(file), raw, memory);
}

ImageData readImageBytes(const std::string& name, std::string_view bytes, bool raw, MemoryBudget* memory) {
    const Opener opener = openerOf(bytes);
    if (!opener) throw Error("cannot read image '{}': expected PNG, JPEG, EXR or another image", name);
    auto stream = std::make_unique<std::istringstream>(std::string(bytes));
    return decode(OpenImage(opener, name, std::move(stream), bytes.size()), raw, memory);
}

std::string encodeExr(const ImageData& image, const std::vector<ImageLayer>& layers,
                      const Metadata& metadata) {
    checkImage(image, true);
    const size_t count = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
    std::vector<EncodedChannel> channels;
    const auto add = [&](const std::string& name, const std::vector<float>& pixels, size_t c, size_t stride) {
        channels.push_back({name, pixels.data() + c, stride});
    };
    if (image.channels == 1) add("Y", image.pixels, 0, 1);
    for (size_t c = 0; c < 3 && image.channels == 3; ++c) add(std::string(1, "RGB"[c]), image.pixels, c, 3);
    for (const ImageLayer& layer : layers) {
        if (layer.pixels.size() != count * layer.channels.size())
            throw Error("cannot write the layer '{}': it does not have the size of the image", layer.name);
        for (size_t c = 0; c < layer.channels.size(); ++c)
            add(channelName(layer, layer.channels[c]), layer.pixels, c, layer.channels.size());
    }
    return encodeExrChannels(image.width, image.height, image.place, channels, metadata);
}

void writeExr(const fs::path& file, const ImageData& image, const std::vector<ImageLayer>& layers,
              const Metadata& metadata) {
    writeFile(file, encodeExr(image, layers, metadata));
}

Metadata readMetadata(const fs::path& file) { return openImage(file).info().metadata; }

ImageInfo readImageInfo(const fs::path& file) { return openImage(file).info(); }

bool isImageFile(const fs::path& file) {
    std::error_code code;
    return fs::is_regular_file(file, code) && openerFor(file);
}

ImageLayer readLayer(const fs::path& file, const std::string& name) {
    OpenImage image = openImage(file);
    const std::vector<std::string>& channels = image.info().channels;
    ImageLayer layer;
    layer.name = name;
    std::vector<size_t> selection;
    for (size_t c = 0; c < channels.size(); ++c) {
        if (!channels[c].starts_with(name + ".")) continue;
        layer.channels.push_back(channels[c].substr(name.size() + 1));
        selection.push_back(c);
    }
    if (selection.empty()) throw Error("image '{}' has no layer '{}'", file.string(), name);
    layer.pixels = selectChannels(image.readPixels(), channels.size(), selection);
    return layer;
}

std::vector<uint8_t> displayBytes(const ImageData& image, float exposure, ToneCurve curve) {
    std::vector<uint8_t> bytes(image.pixels.size());
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const Rgb display =
            tonemap({image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]}, exposure, curve);
        for (size_t c = 0; c < 3; ++c) bytes[i + c] = toByte(display[static_cast<int>(c)]);
    }
    return bytes;
}

std::string encodePng(const ImageData& image, float exposure, ToneCurve curve, const Metadata& metadata) {
    checkImage(image);
    return encodePngBytes(image.width, image.height, displayBytes(image, exposure, curve), metadata);
}

void writePng(const fs::path& file, const ImageData& image, float exposure, ToneCurve curve,
              const Metadata& metadata) {
    writeFile(file, encodePng(image, exposure, curve, metadata));
}

std::string encodePngRaw(const ImageData& image, const Metadata& metadata) {
    checkImage(image);
    std::vector<uint8_t> bytes(image.pixels.size());
    for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = toByte(image.pixels[i]);
    return encodePngBytes(image.width, image.height, bytes, metadata);
}

void writePngRaw(const fs::path& file, const ImageData& image, const Metadata& metadata) {
    writeFile(file, encodePngRaw(image, metadata));
}

}  // namespace metrolux::core
