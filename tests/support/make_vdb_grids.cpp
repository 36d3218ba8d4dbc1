/// Writes grids.vdb, grids of every kind, and no_floats.vdb for tests/unit/io/vdb_file_test.cpp to a folder.

#include <openvdb/openvdb.h>
#include <string>

namespace {

using openvdb::Coord;

template <class Grid>
typename Grid::Ptr grid(const char* name, typename Grid::ValueType background, Coord at,
                        typename Grid::ValueType value) {
    const auto result = Grid::create(background);
    result->setName(name);
    result->getAccessor().setValue(at, value);
    return result;
}

void write(const std::string& path, const openvdb::GridPtrVec& grids) {
    openvdb::io::File file(path);
    file.write(grids);
    file.close();
}

}  // namespace

int main(int, char** argv) {
    openvdb::initialize();
    const std::string folder = argv[1];
    using openvdb::FloatGrid;
    const auto id = grid<openvdb::Int32Grid>("id", 0, Coord(0, 0, 0), 7);
    const auto density = grid<FloatGrid>("density", 0, Coord(2, -3, 4), 0.5f);
    density->getAccessor().setValue(Coord(3, -3, 4), 1);
    density->getAccessor().setValue(Coord(2, -1, 6), 2);
    // x = 1 + i / 2, y = 2 + k / 4, z = 3 - j / 4: rows are multiplied by this.
    const openvdb::Mat4R map(0.5, 0.0, 0.0, 0.0, 0.0, 0.0, -0.25, 0.0, 0.0, 0.25, 0.0, 0.0, 1.0, 2.0, 3.0,
                             1.0);
    density->setTransform(openvdb::math::Transform::createLinearTransform(map));
    const auto heat = grid<FloatGrid>("heat", 0, Coord(0, 0, 0), 7);
    const auto surface = grid<FloatGrid>("surface", 3, Coord(0, 0, 0), 1);
    surface->setGridClass(openvdb::GRID_LEVEL_SET);
    const auto negative = grid<FloatGrid>("negative", 0, Coord(0, 0, 0), -1);
    const auto wide = grid<FloatGrid>("wide", 0, Coord(0, 0, 0), 1);
    wide->getAccessor().setValue(Coord(2000000, 2000000, 2000000), 1);
    const auto frustum = grid<FloatGrid>("frustum", 0, Coord(0, 0, 0), 1);
    frustum->setTransform(openvdb::math::Transform::createFrustumTransform(
        openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 10));
    const auto empty = FloatGrid::create(0);
    empty->setName("empty");
    write(folder + "/grids.vdb", {id, density, heat, surface, negative, wide, frustum, empty});
    write(folder + "/no_floats.vdb", {id});
}
