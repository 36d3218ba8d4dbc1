#pragma once
/// A filter that takes the noise out of a rendering whose passes are kept in two halves.

#include <cstdint>
#include <span>
#include <vector>

namespace metrolux::core {

/// Images of width x height pixels, row by row from the top, channels interleaved. Values are finite.
struct NoisyImage {
    int width = 0, height = 0;
    std::span<const float> color;          ///< 3 a pixel: mean over all passes
    std::span<const float> first, second;  ///< 3 a pixel: means over the passes of each half
    std::span<const float> variance;  ///< 1 a pixel: of the mean's luminance, as if passes were independent
    uint32_t firstPasses = 0, passes = 0;    ///< of the first half, and in all; no half is empty
    std::span<const float> albedo, normal;   ///< 3 a pixel
    std::span<const float> inverseDistance;  ///< 1 a pixel: of the first surface, 0 where none is
};

/// 3 a pixel. Each half is regressed on the features (image/feature_regression.h) with weights from the other
/// half, which also tells the error; of several strengths, and of the image as it is, the best is taken at
/// each place. The result is the same on any number of threads.
std::vector<float> denoise(const NoisyImage& image);

}  // namespace metrolux::core
