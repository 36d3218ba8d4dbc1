#pragma once
#include <array>
#include <cstdint>

namespace metrolux::core {

/// A grid of a .vdb file, as numbers in a box. OpenVDB is behind it, in a library of its own (src/vdb) that
/// is loaded only for scenes with such files.
class VdbGrid {
  public:
    virtual ~VdbGrid() = default;
    /// Of the box of the active voxels, with a layer of what surrounds them on each side.
    virtual std::array<int64_t, 3> resolution() const = 0;
    /// Affine map from the unit cube of these voxels to the space of the file: rows, for columns of points.
    virtual std::array<double, 16> toFile() const = 0;
    /// All values, x fastest.
    virtual void copyTo(float* values) const = 0;
};

/// The one function of that library: a grid of floats by its name, or the first in the order of names where
/// that is empty. What the file says of its memory may not exceed `mostBytes`. Throws std::runtime_error.
using OpenVdbGrid = VdbGrid* (*)(const char* file, const char* name, uint64_t mostBytes);
inline constexpr const char* kOpenVdbGrid = "metroluxOpenVdbGrid";

}  // namespace metrolux::core
