#pragma once
#include "media/grid_cell.h"
#include "media/grid_volume.h"

#include <algorithm>
#include <vector>

namespace metrolux::core {

/// One axis of the grid. Its cells are [i, i + 1] in grid coordinates, of which the unit cube is the part
/// from `low` to `low + period`.
struct GridAxis {
    double low = 0, period = 1;
    int cells = 1;
    /// Of each cell, from -1 to `cells`: where the samples on its two sides are. A ray may come to the
    /// outermost by rounding.
    std::vector<size_t> lower, upper;

    GridAxis(int samples, size_t stride, const GridSettings& settings) {
        const bool isLinear = settings.filter == GridFilter::Trilinear,
                   isNodes = settings.placement == GridPlacement::Nodes;
        period = isNodes ? samples - 1 : samples;
        low = isLinear && !isNodes ? 0.5 : 0.0;
        cells = isNodes ? samples - 1 : isLinear ? samples + 1 : samples;
        const int shift = isLinear && !isNodes ? 1 : 0;
        const auto sample = [&](int i) {
            const bool repeats = settings.wrap == GridWrap::Repeat;
            if (i < 0) i = repeats ? samples - 1 : 0;  // a mirror image begins with the same sample
            if (i >= samples) i = repeats ? 0 : samples - 1;
            return static_cast<size_t>(i) * stride;
        };
        const int least = -shift, most = cells - shift - (isLinear ? 0 : 1);
        for (int cell = -1; cell <= cells; ++cell) {
            lower.push_back(sample(std::clamp(cell - shift, least, most)));
            upper.push_back(isLinear ? sample(std::clamp(cell - shift + 1, least, most)) : lower.back());
        }
    }
    int blocks() const { return (cells + kBlock - 1) / kBlock; }
};

}  // namespace metrolux::core
