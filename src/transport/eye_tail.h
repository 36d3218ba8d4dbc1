#pragma once
#include "image/splat.h"
#include "transport/mis.h"

#include <cmath>
#include <limits>
#include <vector>

namespace metrolux::core {

/// What a path tracer would be surprised by: light that its eye subpaths estimate by larger values than any
/// that they have had so far. Passes of eye subpaths look quiet before the first of these, but light subpaths
/// find them, and know by their MIS weight how rarely an eye subpath does.
class EyeTail {
    /// Of a light subpath: one with less stands for too little, and the sums are quieter.
    static constexpr double kLeastShare = 0.01;

  public:
    /// Per region (EyeFactors::regionOf), luminance: the largest estimate that an eye subpath has had there.
    std::vector<float> largest;
    /// Per region: what a squared error of a pixel counts.
    std::vector<float> worth;
    double pixels = 1;     ///< of the film
    double filmShare = 1;  ///< what a splat anywhere on the film counts: LightSubpathIteration::filmShare

    /// What a path that a light subpath has found with this `value` (luminance of the pixel's estimate)
    /// stands for; nothing if it is no surprise. `count` of hit and nee in the weights. Averages over light
    /// subpaths are sums over the pixels.
    Surprise surprise(uint16_t region, float value, const EyeRival& eye, double count) const {
        // value = f / D, where D = ... + factor count p and p is the density of eye subpaths over the film;
        // alone they would estimate f / (p pixels).
        const double found = std::abs(double(value)), share = double(eye.share);
        if (!(share > 0)) return {std::numeric_limits<double>::infinity(), 0};
        const double alone = found * count * double(eye.factor) / (share * pixels);
        if (!(alone > double(largest[region]))) return {};
        // The light subpath finds its share of the light, and stands for all of it.
        const double all = found / std::max(1 - share, kLeastShare);
        return {double(worth[region]) * all * alone,
                double(worth[region]) * (sqr(share) * all * alone + found * found * count / pixels)};
    }
};

}  // namespace metrolux::core
