#pragma once
/// Pixels on their way to viewers.

#include <metrolux/session.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace metrolux::core::view {

/// A picture at a moment. It never changes, so that all viewers share it.
struct Frame {
    uint64_t version = 0;     ///< grows from frame to frame
    uint64_t generation = 0;  ///< of the side, as in SideState
    int scale = 1;            ///< of a preview: one of its pixels stands for scale x scale
    Crop window;              ///< of the full image at this scale
    Progress progress;
    std::vector<float> color;     ///< 3 a pixel, linear Rec.709
    std::vector<float> variance;  ///< of the mean of the luminance; empty: nobody has asked for it
};

/// What a layer shows: 1 or 3 values a pixel.
struct LayerPixels {
    int width = 0, height = 0, channels = 3;
    std::vector<float> values;
};

/// Estimated relative error of each pixel: sqrt(Var[mean] / (mean^2 + d m^2)), m the mean of all pixels and d
/// BlockedErrorEstimate::kDarkness. The variance is that between passes.
std::vector<float> relativeErrors(std::span<const float> color, std::span<const float> variance);

/// IEEE 754 binary16, little endian; values beyond its range become infinite, which a display shows as white.
std::string halfFloats(std::span<const float> values);

}  // namespace metrolux::core::view
