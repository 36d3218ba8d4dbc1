#pragma once
/// A filter that takes the noise out of a rendering whose passes are kept in two halves.

#include <cstdint>
#include <span>
#include <vector>

namespace metrolux::core {

/// Images of width x height pixels, row by row from the top, channels interleaved.
struct NoisyImage {
    int width = 0, height = 0;
    std::span<const float> color;           ///< 3 a pixel: mean over all passes
    std::span<const float> first, second;   ///< 3 a pixel: means over the passes of each half
    std::span<const float> variance;        ///< 1 a pixel: of the mean's luminance, as if passes were independent
    uint32_t firstPasses = 0, passes = 0;   ///< of the first half, and in all
    std::span<const float> albedo, normal;  ///< 3 a pixel
    std::span<const float> depth;           ///< 1 a pixel
};

std::vector<float> denoise(const NoisyImage& image);

}  // namespace metrolux::core
