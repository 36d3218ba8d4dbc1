#pragma once
#include <metrolux/defaults.h>
#include <metrolux/export.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace metrolux {

/// Pixels that somebody else owns: row by row from the top, channels interleaved.
struct ImageView {
    const float* data = nullptr;
    int height = 0, width = 0, channels = 0;
    std::size_t size() const {
        return static_cast<std::size_t>(height) * static_cast<std::size_t>(width) *
               static_cast<std::size_t>(channels);
    }
    /// The channels of a pixel.
    const float* at(int x, int y) const {
        return data +
               (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                   static_cast<std::size_t>(channels);
    }
};

/// Pixels in an order as ImageView has them.
struct Image {
    std::vector<float> pixels;
    int height = 0, width = 0, channels = 0;
    ImageView view() const { return {pixels.data(), height, width, channels}; }
};

/// How linear values become those of a display: curve(2^exposure * value).
struct Display {
    double exposure = 0;  ///< stops
    /// srgb clips, filmic rolls off highlights. For encodePng() and writeImage() also none: values from 0 to
    /// 1 are display values, as those of heatMap(), and the exposure has no effect.
    std::string curve = "srgb";
};

/// EXR, HDR, PNG, JPEG, BMP, TGA, TIFF, PFM or PPM; integer pixels become linear. Throws Error.
METROLUX_API Image readImage(const std::filesystem::path& file);
/// .exr (32-bit linear) or .png (through `display`), of an image with 3 channels or of gray with 1. The file
/// is replaced as a whole or not at all. Throws Error.
METROLUX_API void writeImage(const std::filesystem::path& file, const ImageView& image,
                             const Display& display = {});
/// The bytes of a .png of an image with 3 channels, or 1. Throws Error for an unknown curve.
METROLUX_API std::string encodePng(const ImageView& image, const Display& display = {});
/// Bytes of a display, 3 a pixel, of an image with 3 channels, or 1. Throws Error for an unknown curve.
METROLUX_API std::vector<std::uint8_t> displayImage(const ImageView& image, const Display& display = {});

/// How far image a is from reference b. Means are over pixels and color channels; pixels that are not finite
/// in either are left out and counted.
struct Difference {
    double mse = 0;            ///< mean (a-b)^2
    double relMse = 0;         ///< mean (a-b)^2 / (b^2 + epsilon)
    double trimmedRelMse = 0;  ///< the same without the 0.1 % of the pixels where it is largest
    double smape = 0;          ///< mean 2|a-b| / (|a|+|b|)
    double bias = 0;           ///< (mean a - mean b) / mean b
    double biasError = 0;      ///< its standard error, from tiles of 16x16 pixels; NaN with fewer than two
    double meanA = 0, meanB = 0;
    std::size_t pixels = 0, nonFinite = 0;
};
/// Throws Error when the sizes differ.
METROLUX_API Difference compare(const ImageView& a, const ImageView& b, double epsilon = kDefaultEpsilon);
/// Colors of the relative error of each pixel, 3 channels in [0, 1]: black 0.001, blue, violet, orange,
/// yellow, white 1. Throws Error when the sizes differ.
METROLUX_API Image heatMap(const ImageView& a, const ImageView& b, double epsilon = kDefaultEpsilon);

}  // namespace metrolux
