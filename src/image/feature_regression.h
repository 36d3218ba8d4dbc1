#pragma once
/// Regression of noisy colors on features in windows around pixels, after "Nonlinearly Weighted First-order
/// Regression for Denoising Monte Carlo Renderings" [Bitterli et al. 2016], whose models are fitted around
/// every second pixel of every second row here, and have the place in the picture among their features.

#include "image/padded_plane.h"

#include <array>
#include <span>
#include <vector>

namespace metrolux::core {

/// 1; albedo (3), normal (3) and inverse distance, each in units of what makes a difference; x and y.
inline constexpr size_t kFeatures = 10;
/// Of these, neighbors are compared by those before the place.
inline constexpr size_t kComparedFeatures = 8;
using FeatureVector = std::array<float, kFeatures>;

struct RegressionInput {
    const ColorPlanes& color;          ///< what is filtered
    const ColorPlanes& guide;          ///< the same with noise independent of that of `color`
    const ColorPlanes& guideVariance;  ///< of the guide's noise
    const PaddedPlane& trust;          ///< weight of a pixel's color, below 1 for outliers
    std::span<const FeatureVector> features;
};

/// The colors as first-order functions of the features, an image for each of `strengths`. Neighbors count as
/// much as the patches around them are alike in the guide: with strength k, a difference of k standard
/// deviations beyond what noise explains counts 1/e ([Rousselle et al. 2012] for the distance). Planes have
/// values beyond the border.
std::vector<ColorPlanes> regress(const RegressionInput& input, std::span<const float> strengths);

}  // namespace metrolux::core
