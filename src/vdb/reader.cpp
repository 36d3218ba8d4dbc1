/// The only code that knows OpenVDB. It is a library that io/vdb_file.cpp loads, so that other scenes need
/// not.

#include "io/vdb_library.h"

#include <memory>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <stdexcept>
#include <string>

namespace metrolux::core {
namespace {

class FloatGrid final : public VdbGrid {
  public:
    explicit FloatGrid(openvdb::FloatGrid::ConstPtr grid) : grid_(std::move(grid)) {
        box_ = grid_->evalActiveVoxelBoundingBox();
        if (box_.empty()) throw std::runtime_error("grid \"" + grid_->getName() + "\" has no active voxels");
        box_.expand(1);
        if (!grid_->transform().isLinear())
            throw std::runtime_error("grid \"" + grid_->getName() +
                                     "\" has a transform with perspective, expected a linear one");
    }
    std::array<int64_t, 3> resolution() const override {
        std::array<int64_t, 3> result{};
        for (int a = 0; a < 3; ++a) result[size_t(a)] = int64_t(box_.max()[a]) - int64_t(box_.min()[a]) + 1;
        return result;
    }
    std::array<double, 16> toFile() const override {
        // Voxels have their centers at whole numbers. OpenVDB multiplies rows of points by matrices.
        const openvdb::Mat4R map = grid_->transform().baseMap()->getAffineMap()->getMat4();
        const auto n = resolution();
        std::array<double, 16> rows{};
        for (int row = 0; row < 4; ++row) {
            double shift = map(3, row);
            for (int a = 0; a < 3; ++a) {
                rows[size_t(row) * 4 + size_t(a)] = map(a, row) * double(n[size_t(a)]);
                shift += map(a, row) * (box_.min()[a] - 0.5);
            }
            rows[size_t(row) * 4 + 3] = shift;
        }
        return rows;
    }
    void copyTo(float* values) const override {
        openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box_, values);
        openvdb::tools::copyToDense(*grid_, dense);
    }

  private:
    openvdb::FloatGrid::ConstPtr grid_;
    openvdb::CoordBBox box_;
};

VdbGrid* open(const std::string& path, const std::string& wanted, uint64_t mostBytes) {
    openvdb::initialize();
    openvdb::io::File file(path);
    file.open(false);  // now, not when a value is asked for
    std::string found;
    for (auto name = file.beginName(); name != file.endName(); ++name) {
        const openvdb::GridBase::ConstPtr grid = file.readGridMetadata(name.gridName());
        found += (found.empty() ? "\"" : ", \"") + name.gridName() + "\" (" + grid->valueType() + ")";
        if (!grid->isType<openvdb::FloatGrid>() || (!wanted.empty() && name.gridName() != wanted)) continue;
        if (grid->getGridClass() == openvdb::GRID_LEVEL_SET)
            throw std::runtime_error("grid \"" + name.gridName() +
                                     "\" is a level set, whose values are distances; expected a fog volume");
        const auto bytes = grid->getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_MEM_BYTES);
        if (bytes && bytes->value() > 0 && uint64_t(bytes->value()) > mostBytes)
            throw std::runtime_error("grid \"" + name.gridName() + "\" needs " +
                                     std::to_string(bytes->value()) +
                                     " bytes, more than are left for the scene");
        return new FloatGrid(openvdb::gridConstPtrCast<openvdb::FloatGrid>(file.readGrid(name.gridName())));
    }
    throw std::runtime_error("found " + (found.empty() ? "no grids" : found) + ", expected a grid of floats" +
                             (wanted.empty() ? "" : " named \"" + wanted + "\""));
}

}  // namespace
}  // namespace metrolux::core

extern "C" metrolux::core::VdbGrid* metroluxOpenVdbGrid(const char* file, const char* name,
                                                        uint64_t mostBytes) {
    try {
        return metrolux::core::open(file, name, mostBytes);
    } catch (const std::exception& error) {
        throw std::runtime_error(error.what());
    }
}
