#pragma once
#include "base/memory_budget.h"
#include "media/grid_volume.h"

#include <filesystem>
#include <string>

namespace metrolux::core {

struct VdbFile {
    GridSamples samples;
    Transform toFile;  ///< from the unit cube of the samples to the coordinates of the file
};

/// A grid of floats of an OpenVDB file, by its name or the first in the order of names: the box of its active
/// voxels with a layer of background around it. Throws Error with the file's name, also where this was built
/// without OpenVDB.
VdbFile readVdbFile(const std::filesystem::path& file, const std::string& grid,
                    MemoryBudget* memory = nullptr);

}  // namespace metrolux::core
