#pragma once
#include "base/memory_budget.h"
#include "image/tonemap.h"

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace metrolux::core {

/// Where the pixels of an image lie in the full one, of which they are a crop: the data window and the
/// display window of an EXR. Without a size, or in formats that have none, the pixels are all of it.
struct ImagePlace {
    int x = 0, y = 0, fullWidth = 0, fullHeight = 0;
    bool isCrop() const { return fullWidth > 0; }
};

struct ImageData {
    int width = 0, height = 0, channels = 0;
    std::vector<float> pixels;  ///< row by row from the top, channels interleaved
    ImagePlace place = {};

    const float* at(int x, int y) const {
        return &pixels[(static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
                       static_cast<size_t>(channels)];
    }
};

/// Reads EXR, HDR, PNG, JPEG, BMP, TGA, TIFF, PFM and PPM. Thread-safe. Which of them a file is, its first
/// bytes say (TGA has none: there it is the name). No format refers to other files: what one names may be on
/// another machine.
///
/// 1 channel is gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha; alpha is not multiplied into the colors, nor
/// divided out of them. Of a file with more channels R, G, B and A are taken. Integer pixels become linear
/// (sRGB decoded) unless `raw`, which only scales them to [0, 1]; floating-point pixels are as in the file.
/// Throws Error naming the file. The size is checked against the file's and against `memory`, where the
/// pixels are booked, before anything is allocated.
ImageData readImage(const std::filesystem::path& file, bool raw, MemoryBudget* memory = nullptr);

/// The same of the bytes of such a file, but for TGA, which they alone do not tell; `name` stands for it in
/// messages.
ImageData readImageBytes(const std::string& name, std::string_view bytes, bool raw,
                         MemoryBudget* memory = nullptr);

/// The layer whose only channel is that of the image: "A", coverage.
inline constexpr const char* kAlphaLayer = "alpha";

/// More channels of an EXR, named "name.channel", and those of cryptomattes "name00.R".
struct ImageLayer {
    std::string name;                   ///< "albedo"
    std::vector<std::string> channels;  ///< "R", "G", "B"; those of cryptomattes are "00.R", "01.R" ...
    std::vector<float> pixels;          ///< channels interleaved
};
/// Row by row; points are rows that are multiplied from the left, as in OpenEXR.
using Matrix = std::array<float, 16>;
using MetadataValue = std::variant<std::string, double, int, Matrix>;
using Metadata = std::vector<std::pair<std::string, MetadataValue>>;

/// Writes 32-bit float EXR with lossless compression, Rec.709 chromaticities and the metadata as attributes.
/// The file is replaced as a whole or not at all. `image` has 3 channels, or 1 (Y). Throws Error.
void writeExr(const std::filesystem::path& file, const ImageData& image,
              const std::vector<ImageLayer>& layers = {}, const Metadata& metadata = {});
/// The bytes of that file.
std::string encodeExr(const ImageData& image, const std::vector<ImageLayer>& layers = {},
                      const Metadata& metadata = {});
/// Attributes of an image file of the types that Metadata knows: of EXR, and the text in PNG.
Metadata readMetadata(const std::filesystem::path& file);
/// What an image file says of itself.
struct ImageInfo {
    std::string format;  ///< "openexr", "png" ...
    int width = 0, height = 0;
    ImagePlace place;
    std::vector<std::string> channels;
    Metadata metadata;
};
/// Reads no pixels. Throws Error.
ImageInfo readImageInfo(const std::filesystem::path& file);
/// Whether the first bytes (of TGA: the name) are those of a format that is read.
bool isImageFile(const std::filesystem::path& file);
/// Channels of a layer that writeExr has written. Throws Error when the file has no such layer.
ImageLayer readLayer(const std::filesystem::path& file, const std::string& name);

/// Writes 8-bit PNG of an image with 3 channels: display = curve(2^exposure * value). As a whole or not at
/// all.
void writePng(const std::filesystem::path& file, const ImageData& image, float exposure = 0,
              ToneCurve curve = ToneCurve::Srgb, const Metadata& metadata = {});
/// The bytes of that file.
std::string encodePng(const ImageData& image, float exposure = 0, ToneCurve curve = ToneCurve::Srgb,
                      const Metadata& metadata = {});
/// The values in it, 3 a pixel.
std::vector<uint8_t> displayBytes(const ImageData& image, float exposure, ToneCurve curve);
/// The same without tone mapping: values in [0, 1] are display values.
void writePngRaw(const std::filesystem::path& file, const ImageData& image, const Metadata& metadata = {});
/// The bytes of that file.
std::string encodePngRaw(const ImageData& image, const Metadata& metadata = {});

}  // namespace metrolux::core
