#pragma once
#include "base/memory_budget.h"
#include "media/grid_volume.h"

#include <filesystem>

namespace metrolux::core {

struct VolumeFile {
    GridSamples samples;
    Imath::Box3d box;  ///< of the data, as the file has it
};

/// Mitsuba's grids (.vol, version 3) of 32 or 16 bit floats or of bytes, which are fractions of 255, with one
/// or three channels. Sizes are checked against the file's before memory is booked and taken. Throws Error
/// with the file's name, what was found and what was expected.
VolumeFile readVolumeFile(const std::filesystem::path& file, MemoryBudget* memory = nullptr,
                          SampleRange range = SampleRange::NotNegative);

}  // namespace metrolux::core
