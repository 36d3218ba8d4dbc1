#include "image/image_io.h"

#include "base/error.h"
#include "image/atomic_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <array>
#include <cctype>
#include <fstream>
#include <string_view>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestSide = 1 << 17;
constexpr uint64_t kMostValues = uint64_t{1} << 29;  // 2 GiB of floats
/// CIE xy of red, green, blue and white: ITU-R BT.709 with D65.
constexpr float kRec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

/// No compression of the formats read here shrinks an image of more than kFreeBytes by more than this factor
/// (EXR's PIZ of a black image comes near).
constexpr uint64_t kMostExpansion = 1 << 16;
constexpr uint64_t kFreeBytes = uint64_t{64} << 20;

struct Signature {
    std::string_view bytes;
    const char* reader;  ///< OpenImageIO's name
};
using namespace std::string_view_literals;
constexpr Signature kSignatures[] = {
    {"\x76\x2f\x31\x01"sv, "openexr"},
    {"\x89PNG\r\n\x1a\n"sv, "png"},
    {"\xff\xd8\xff"sv, "jpeg"},
    {"#?"sv, "hdr"},
    {"BM"sv, "bmp"},
    {"II*\0"sv, "tiff"},
    {"MM\0*"sv, "tiff"},
    {"II+\0"sv, "tiff"},
    {"MM\0+"sv, "tiff"},
    {"P1"sv, "pnm"},
    {"P2"sv, "pnm"},
    {"P3"sv, "pnm"},
    {"P4"sv, "pnm"},
    {"P5"sv, "pnm"},
    {"P6"sv, "pnm"},
    {"PF"sv, "pnm"},
    {"Pf"sv, "pnm"},
};

/// OpenImageIO's name of the reader for bytes; null if they begin none of the formats.
const char* readerOf(std::string_view bytes) {
    for (const Signature& s : kSignatures)
        if (bytes.starts_with(s.bytes)) return s.reader;
    return nullptr;
}

/// The same for a file; null if it is none of the formats.
const char* readerFor(const fs::path& file) {
    std::array<char, 16> head{};
    std::ifstream stream(file, std::ios::binary);
    stream.read(head.data(), head.size());
    const std::string_view found(head.data(), static_cast<size_t>(stream.gcount()));
    if (const char* reader = readerOf(found)) return reader;
    std::string extension = file.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension == ".tga" && !found.empty() ? "targa" : nullptr;
}

/// `fileSize`: in bytes, 0 where it is not known.
void checkSize(const fs::path& file, const OIIO::ImageSpec& spec, uint64_t fileSize) {
    const uint64_t values = static_cast<uint64_t>(std::max(spec.width, 0)) *
                            static_cast<uint64_t>(std::max(spec.height, 0)) *
                            static_cast<uint64_t>(std::max(spec.nchannels, 0));
    if (values == 0) throw Error("cannot read image '{}': it has no pixels", file.string());
    if (spec.width > kLargestSide || spec.height > kLargestSide || values > kMostValues)
        throw Error(
            "cannot read image '{}': {}x{} pixels of {} channels is more than the largest size of {} values",
            file.string(), spec.width, spec.height, spec.nchannels, kMostValues);
    const uint64_t bytes = values * spec.format.size();
    if (bytes > kFreeBytes && fileSize > 0 && bytes / kMostExpansion > fileSize)
        throw Error("cannot read image '{}': {}x{} pixels of {} channels are {}, which its {} cannot hold",
                    file.string(), spec.width, spec.height, spec.nchannels, sizeText(bytes),
                    sizeText(fileSize));
}

/// `bytes`, if not null, in place of the file, which has to live as long as the result.
std::unique_ptr<OIIO::ImageInput> openWith(const char* reader, const fs::path& file, uint64_t fileSize,
                                           OIIO::Filesystem::IOProxy* bytes) {
    auto input = OIIO::ImageInput::create(reader);
    if (!input) throw Error("cannot read image '{}': {}", file.string(), OIIO::geterror());
    if (bytes && !input->supports("ioproxy"))
        throw Error("cannot read image '{}': {} cannot be read from memory", file.string(), reader);
    if (bytes) input->set_ioproxy(bytes);
    OIIO::ImageSpec request, spec;
    request.attribute("oiio:UnassociatedAlpha", 1);
    if (!input->open(file.string(), spec, request))
        throw Error("cannot read image '{}': {}", file.string(), input->geterror());
    if (spec.deep)
        throw Error("cannot read image '{}': it has deep pixels, expected flat ones", file.string());
    if (spec.depth > 1) throw Error("cannot read image '{}': it is a volume", file.string());
    checkSize(file, spec, fileSize);
    return input;
}

std::unique_ptr<OIIO::ImageInput> openImage(const fs::path& file) {
    std::error_code code;
    if (!fs::exists(file, code)) throw Error("cannot read image '{}': there is no such file", file.string());
    if (fs::is_directory(file, code)) throw Error("cannot read image '{}': it is a folder", file.string());
    const char* reader = readerFor(file);
    if (!reader)
        throw Error("cannot read image '{}': expected EXR, HDR, PNG, JPEG, BMP, TGA, TIFF, PFM or PPM",
                    file.string());
    const uint64_t size = fs::file_size(file, code);
    return openWith(reader, file, code ? 0 : size, nullptr);
}

std::vector<float> readChannels(OIIO::ImageInput& input, const fs::path& file) {
    const OIIO::ImageSpec& spec = input.spec();
    std::vector<float> pixels(static_cast<size_t>(spec.width) * spec.height * spec.nchannels);
    if (!input.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()))
        throw Error("cannot read image '{}': {}", file.string(), input.geterror());
    return pixels;
}

/// Books the pixels to be kept, for which there must be room besides the file's.
void bookImage(const fs::path& file, const OIIO::ImageSpec& spec, size_t channels, MemoryBudget* memory) {
    if (!memory) return;
    const uint64_t pixels = static_cast<uint64_t>(spec.width) * static_cast<uint64_t>(spec.height);
    try {
        memory->take(pixels * channels * sizeof(float), "the image");
        memory->require(pixels * static_cast<uint64_t>(spec.nchannels) * sizeof(float), "reading the image");
    } catch (const Error& error) {
        throw Error("cannot read image '{}': {}", file.string(), error.what());
    }
}

/// The given channels of interleaved pixels.
std::vector<float> selectChannels(const std::vector<float>& pixels, int channels,
                                  const std::vector<int>& selection) {
    const size_t count = pixels.size() / static_cast<size_t>(channels);
    std::vector<float> result;
    result.reserve(count * selection.size());
    for (size_t i = 0; i < count; ++i)
        for (int c : selection)
            result.push_back(pixels[i * static_cast<size_t>(channels) + static_cast<size_t>(c)]);
    return result;
}

/// Which channels of the file make the image.
std::vector<int> imageChannels(const OIIO::ImageSpec& spec) {
    const int r = spec.channelindex("R"), g = spec.channelindex("G"), b = spec.channelindex("B");
    const int a = spec.channelindex("A"), y = spec.channelindex("Y");
    std::vector<int> result;
    if (r >= 0 && g >= 0 && b >= 0) {
        result = {r, g, b};
        if (a >= 0) result.push_back(a);
    } else if (y >= 0) {
        result = {y};
        if (a >= 0) result.push_back(a);
    } else {
        const int count = spec.nchannels <= 4 ? spec.nchannels : 3;
        for (int c = 0; c < count; ++c) result.push_back(c);
    }
    return result;
}

ImagePlace placeOf(const OIIO::ImageSpec& spec) {
    if (spec.x == spec.full_x && spec.y == spec.full_y && spec.width == spec.full_width &&
        spec.height == spec.full_height)
        return {};
    return {spec.x - spec.full_x, spec.y - spec.full_y, spec.full_width, spec.full_height};
}

/// Name of a channel in the file.
std::string channelName(const ImageLayer& layer, const std::string& channel) {
    return layer.name == kAlphaLayer ? "A" : layer.name + "." + channel;
}

void setMetadata(OIIO::ImageSpec& spec, const Metadata& metadata) {
    for (const auto& [name, value] : metadata) {
        if (const auto* text = std::get_if<std::string>(&value)) spec.attribute(name, *text);
        if (const auto* number = std::get_if<double>(&value))
            spec.attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::DOUBLE), number);
        if (const auto* integer = std::get_if<int>(&value)) spec.attribute(name, *integer);
        if (const auto* matrix = std::get_if<Matrix>(&value))
            spec.attribute(name, OIIO::TypeMatrix44, matrix->data());
    }
}

/// The bytes of a file. The libraries do not report every failure of a disk, so they never see one.
std::string encode(const char* format, const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type,
                   const void* pixels) {
    auto output = OIIO::ImageOutput::create(format);
    if (!output) throw Error("cannot write {}: {}", format, OIIO::geterror());
    OIIO::Filesystem::IOVecOutput memory;
    const std::string name = fmt::format("image.{}", format);
    if (!output->set_ioproxy(&memory) || !output->open(name, spec) || !output->write_image(type, pixels) ||
        !output->close())
        throw Error("cannot write {}: {}", format, output->geterror());
    const std::vector<unsigned char>& bytes = memory.buffer();
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void checkImage(const ImageData& image, bool mayBeGray = false) {
    if ((image.channels != 3 && !(mayBeGray && image.channels == 1)) || image.width <= 0 ||
        image.height <= 0 ||
        image.pixels.size() != static_cast<size_t>(image.width) * static_cast<size_t>(image.height) *
                                   static_cast<size_t>(image.channels))
        throw Error("cannot write an image of {}x{} pixels, {} channels and {} values: expected 3 channels",
                    image.width, image.height, image.channels, image.pixels.size());
}

std::string encodePng8(const ImageData& image, const std::vector<uint8_t>& bytes, const Metadata& metadata) {
    OIIO::ImageSpec spec(image.width, image.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    setMetadata(spec, metadata);
    return encode("png", spec, OIIO::TypeDesc::UINT8, bytes.data());
}

uint8_t toByte(float display) {
    return static_cast<uint8_t>(std::lround(255 * (display > 0 ? std::min(display, 1.0f) : 0.0f)));
}

ImageData decode(OIIO::ImageInput& input, const fs::path& file, bool raw, MemoryBudget* memory) {
    const OIIO::ImageSpec& spec = input.spec();
    ImageData image;
    image.width = spec.width;
    image.height = spec.height;
    image.place = placeOf(spec);
    const std::vector<int> selection = imageChannels(spec);
    image.channels = static_cast<int>(selection.size());
    bookImage(file, spec, selection.size(), memory);
    image.pixels = readChannels(input, file);
    if (image.channels != spec.nchannels)
        image.pixels = selectChannels(image.pixels, spec.nchannels, selection);

    if (!raw && !spec.format.is_floating_point()) {
        const int colors = image.channels % 2 == 0 ? image.channels - 1 : image.channels;
        // Files of 8 bits have 256 values: a table saves the power function for each texel.
        const bool bytes = spec.format == OIIO::TypeDesc::UINT8;
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
    return decode(*openImage(file), file, raw, memory);
}

ImageData readImageBytes(const std::string& name, std::string_view bytes, bool raw, MemoryBudget* memory) {
    const char* reader = readerOf(bytes);
    if (!reader) throw Error("cannot read image '{}': expected PNG, JPEG, EXR or another image", name);
    OIIO::Filesystem::IOMemReader proxy(const_cast<char*>(bytes.data()), bytes.size());
    const auto input = openWith(reader, name, bytes.size(), &proxy);
    return decode(*input, name, raw, memory);
}

std::string encodeExr(const ImageData& image, const std::vector<ImageLayer>& layers,
                      const Metadata& metadata) {
    checkImage(image, true);
    const size_t count = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
    std::vector<std::string> names =
        image.channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
    const auto own = static_cast<std::ptrdiff_t>(image.channels);
    for (const ImageLayer& layer : layers) {
        if (layer.pixels.size() != count * layer.channels.size())
            throw Error("cannot write the layer '{}': it does not have the size of the image", layer.name);
        for (const std::string& channel : layer.channels) names.push_back(channelName(layer, channel));
    }
    std::vector<float> pixels;
    pixels.reserve(count * names.size());
    for (size_t i = 0; i < count; ++i) {
        pixels.insert(pixels.end(), image.pixels.begin() + own * static_cast<std::ptrdiff_t>(i),
                      image.pixels.begin() + own * static_cast<std::ptrdiff_t>(i + 1));
        for (const ImageLayer& layer : layers) {
            const size_t n = layer.channels.size();
            pixels.insert(pixels.end(), layer.pixels.begin() + static_cast<std::ptrdiff_t>(n * i),
                          layer.pixels.begin() + static_cast<std::ptrdiff_t>(n * (i + 1)));
        }
    }
    OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = names;
    if (image.place.isCrop()) {
        spec.x = image.place.x;
        spec.y = image.place.y;
        spec.full_width = image.place.fullWidth;
        spec.full_height = image.place.fullHeight;
    }
    spec.attribute("compression", "zip");
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), kRec709);
    setMetadata(spec, metadata);
    return encode("openexr", spec, OIIO::TypeDesc::FLOAT, pixels.data());
}

void writeExr(const fs::path& file, const ImageData& image, const std::vector<ImageLayer>& layers,
              const Metadata& metadata) {
    writeFile(file, encodeExr(image, layers, metadata));
}

namespace {

Metadata metadataOf(const OIIO::ImageSpec& spec) {
    Metadata result;
    for (const OIIO::ParamValue& p : spec.extra_attribs) {
        if (p.type() == OIIO::TypeDesc::STRING) result.emplace_back(p.name().string(), p.get_string());
        if (p.type() == OIIO::TypeDesc::INT) result.emplace_back(p.name().string(), p.get_int());
        if (p.type() == OIIO::TypeDesc::FLOAT) result.emplace_back(p.name().string(), double{p.get_float()});
        if (p.type() == OIIO::TypeDesc::DOUBLE)
            result.emplace_back(p.name().string(), *static_cast<const double*>(p.data()));
        if (p.type() == OIIO::TypeMatrix44) {
            Matrix matrix;
            std::copy_n(static_cast<const float*>(p.data()), matrix.size(), matrix.begin());
            result.emplace_back(p.name().string(), matrix);
        }
    }
    return result;
}

}  // namespace

Metadata readMetadata(const fs::path& file) { return metadataOf(openImage(file)->spec()); }

ImageInfo readImageInfo(const fs::path& file) {
    const auto input = openImage(file);
    const OIIO::ImageSpec& spec = input->spec();
    return {input->format_name(), spec.width,        spec.height,
            placeOf(spec),        spec.channelnames, metadataOf(spec)};
}

bool isImageFile(const fs::path& file) {
    std::error_code code;
    return fs::is_regular_file(file, code) && readerFor(file);
}

ImageLayer readLayer(const fs::path& file, const std::string& name) {
    const auto input = openImage(file);
    const OIIO::ImageSpec& spec = input->spec();
    ImageLayer layer;
    layer.name = name;
    std::vector<int> selection;
    for (int c = 0; c < spec.nchannels; ++c) {
        const std::string& channel = spec.channelnames[static_cast<size_t>(c)];
        if (channel.rfind(name + ".", 0) != 0) continue;
        layer.channels.push_back(channel.substr(name.size() + 1));
        selection.push_back(c);
    }
    if (selection.empty()) throw Error("image '{}' has no layer '{}'", file.string(), name);
    layer.pixels = selectChannels(readChannels(*input, file), spec.nchannels, selection);
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
    return encodePng8(image, displayBytes(image, exposure, curve), metadata);
}

void writePng(const fs::path& file, const ImageData& image, float exposure, ToneCurve curve,
              const Metadata& metadata) {
    writeFile(file, encodePng(image, exposure, curve, metadata));
}

std::string encodePngRaw(const ImageData& image, const Metadata& metadata) {
    checkImage(image);
    std::vector<uint8_t> bytes(image.pixels.size());
    for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = toByte(image.pixels[i]);
    return encodePng8(image, bytes, metadata);
}

void writePngRaw(const fs::path& file, const ImageData& image, const Metadata& metadata) {
    writeFile(file, encodePngRaw(image, metadata));
}

}  // namespace metrolux::core
