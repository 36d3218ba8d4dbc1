#pragma once
#include "base/uninitialized.h"
#include "media/volume.h"

namespace metrolux::core {

/// Samples on a regular grid.
struct GridSamples {
    Imath::V3i resolution{1};  ///< number of samples along x, y, z
    int channels = 1;          ///< 1 or 3
    /// Sample (x, y, z) has its channels at ((z * resolution.y + y) * resolution.x + x) * channels.
    UninitializedVector<float> values;
};

enum class GridFilter { Trilinear, Nearest };
/// What is beyond the unit cube: the nearest value inside, the grid again, or its mirror image in turn.
enum class GridWrap { Clamp, Repeat, Mirror };
/// Where samples lie in the unit cube, whose axis of n samples is [0, 1].
enum class GridPlacement {
    Cells,  ///< at (i + 1/2) / n, as in Mitsuba 3
    Nodes   ///< at i / (n - 1), the first and the last on the faces; nothing outside, as in Mitsuba 0.6
};

struct GridSettings {
    GridFilter filter = GridFilter::Trilinear;
    GridWrap wrap = GridWrap::Clamp;
    GridPlacement placement = GridPlacement::Cells;
    Transform toWorld{};  ///< from the space of the unit cube; affine
};

/// What samples may be; finite they are in any case. Distances have a sign.
enum class SampleRange { NotNegative, Signed };
/// Throws Error unless the counts fit each other and all values are in range.
void checkSamples(const GridSamples& samples, SampleRange range = SampleRange::NotNegative);
/// Throws Error as checkSamples(), unless toWorld is affine and can be inverted, and for Nodes unless there
/// are two samples an axis at least and the filter is trilinear.
VolumePtr makeGridVolume(GridSamples samples, const GridSettings& settings);
/// Bytes that a volume needs beside its samples, for who books memory.
uint64_t gridVolumeBytes(const Imath::V3i& resolution);

}  // namespace metrolux::core
