#pragma once
#include "base/math.h"

#include <memory>
#include <string>
#include <vector>

namespace metrolux::core {

/// Separable reconstruction filter, tabulated as a piecewise-constant function so that sampling and
/// evaluation are exactly consistent: eye subpaths draw their raster position from |h| around their pixel,
/// light subpaths splat with h. Near the border of the image the filter is cut off and renormalized (what a
/// renderer that divides by the sum of weights converges to).
class ReconstructionFilter {
  public:
    enum class Kind { Box, Tent, Gaussian, Mitchell, CatmullRom, Lanczos };
    struct Parameters {
        float radius = 0;                  ///< 0: the filter's default
        float stddev = 0.5f;               ///< gaussian
        float b = 1.0f / 3, c = 1.0f / 3;  ///< mitchell
        int lobes = 3;                     ///< lanczos
    };
    /// Unknown kinds are the loader's business.
    ReconstructionFilter(Kind kind, const Parameters& parameters);

    Kind kind() const { return kind_; }
    float radius() const { return radius_; }

    /// Sample of one axis. `pixel` is the index along the axis, `size` the number of pixels of the full image
    /// along it. Returns the raster coordinate in [0, size] and multiplies `weight` by h / (pdf * integral of
    /// h over the image).
    float sample(int pixel, int size, float u, float& weight) const;
    /// h((x - (pixel + 0.5))) / integral of h over [0, size]: the weight of a splat at raster coordinate x
    /// for a pixel.
    float evaluate(int pixel, int size, float x) const;
    /// Sum over all pixels of the squared weights of a splat, mean over its positions within a pixel: 1 for a
    /// box of one pixel. Away from the border.
    double squaredWeights() const;

  private:
    /// Part of the table that lies inside the image, in cells.
    struct Cut {
        double lower, upper;
    };
    Cut cut(int pixel, int size) const;
    /// Whether that is all of it, for a pixel with this center.
    bool isInside(float center, int size) const {
        return center >= radius_ && center + radius_ <= static_cast<float>(size);
    }

    Kind kind_;
    float radius_;
    std::vector<float> table_;  // h at cell centers over [-radius, radius]
    std::vector<double> signedCdf_, absCdf_;
    std::vector<uint32_t> guide_;  // where to begin the search in absCdf_, for equal shares of its total
};

/// Mitsuba's names: box, tent, gaussian, mitchell, catmullrom, lanczos.
const std::vector<std::pair<std::string, ReconstructionFilter::Kind>>& filterNames();
const std::string& filterName(ReconstructionFilter::Kind kind);
/// Throws Error for an unknown name, with the nearest known one.
ReconstructionFilter::Kind filterKind(const std::string& name);

}  // namespace metrolux::core
