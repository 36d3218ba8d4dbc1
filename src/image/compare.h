#pragma once
#include "image/image_io.h"

#include <metrolux/defaults.h>

namespace metrolux::core {

/// How far image `a` is from reference `b`. Means are over pixels and color channels alike (alpha is left
/// out, a gray image counts as three equal channels). Pixels that are not finite in either image are left out
/// and counted.
struct ImageDifference {
    double mse = 0;            ///< mean (a-b)^2
    double relMse = 0;         ///< mean (a-b)^2 / (b^2 + epsilon)
    double trimmedRelMse = 0;  ///< the same without the 0.1 % of the pixels where it is largest (rounded up)
    double smape = 0;          ///< mean 2|a-b| / (|a|+|b|), in [0, 2]; 0 where both are 0
    double bias = 0;           ///< (mean a - mean b) / mean b; infinite or NaN for a black reference
    /// Standard error of `bias`, from the scatter of a-b between tiles of 16x16 pixels, which are treated as
    /// independent. NaN with fewer than two tiles.
    double biasError = 0;
    double meanA = 0, meanB = 0;
    size_t pixels = 0;     ///< that were compared
    size_t nonFinite = 0;  ///< that were left out
};

inline constexpr double kRelMseEpsilon = kDefaultEpsilon;

/// Throws Error when the sizes differ.
ImageDifference compareImages(const ImageData& a, const ImageData& b, double epsilon = kRelMseEpsilon);

/// Display values of the relative error of each pixel, sqrt(mean over channels (a-b)^2 / (b^2 + epsilon)), on
/// a logarithmic scale: black at 0.001 and below, blue, violet, orange and yellow, to white at 1 and above;
/// green where a pixel is not finite. Throws Error when the sizes differ.
ImageData errorHeatMap(const ImageData& a, const ImageData& b, double epsilon = kRelMseEpsilon);

}  // namespace metrolux::core
