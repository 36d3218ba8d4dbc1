#pragma once
#include "image/splat.h"
#include "integrators/own_image.h"

#include <vector>

namespace metrolux::core {

/// What a contribution to a pixel is worth in a target F that asks for relative error: one over what the
/// image shows there so far, so that chains do not spend all their steps where it is bright.
class PixelImportance {
  public:
    /// From the mean of the passes so far (all alike before the first), smoothed over kReach pixels to either
    /// side, since noise in it would draw chains away from what they have just found. On average a luminance
    /// is multiplied by one: F keeps its scale.
    /// A pixel is not worth more than one of the share `darkest` of the image's mean luminance.
    void update(const OwnImage& image, double darkest);
    /// For a target: what is dim is not worth all chains.
    static constexpr double kDarkestOfTarget = 0.1;
    /// For noise, which is compared as relMSE is.
    static constexpr double kDarkestOfNoise = 0.02;

    /// Of a pixel, an index in the window.
    float of(size_t pixel) const { return values_[pixel]; }
    /// Sum over the splats of luminance times importance: F(u) of docs/explain/algorithm.md section 3 with
    /// this target.
    double size(const SplatList& splats) const;
    /// Sum of the squares of the same: the noise that they bring in relative terms. `ofFilm`: of film splats,
    /// a square of one such splat leaves this much in the pixels.
    double squares(const SplatList& splats, double ofFilm) const;

  private:
    static constexpr int kReach = 2;

    /// Magnitude times importance.
    double sizeOf(const SplatList::PixelSplat& splat) const {
        return double(magnitude(splat.value) * values_[splat.pixel]);
    }
    double sizeOf(const SplatList::FilmSplat& splat) const;

    FilmWindow window_;
    std::vector<float> values_;
};

/// F(u) of a light subpath's splats with a target, which may be null.
inline double sizeOf(const SplatList& splats, const PixelImportance* target) {
    return target ? target->size(splats) : splats.size();
}

}  // namespace metrolux::core
