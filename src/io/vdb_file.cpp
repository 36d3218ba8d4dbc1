#include "io/vdb_file.h"

#include "base/error.h"
#include "base/loaded_library.h"
#include "io/lfs_pointer.h"
#include "io/vdb_library.h"

#include <memory>
#include <stdexcept>

namespace metrolux::core {
namespace {

OpenVdbGrid loadOpenVdb() {
#ifdef METROLUX_OPENVDB
    constexpr const char* kLibrary = "metrolux_vdb.so";
    void* const open = loadFunction(kLibrary, kOpenVdbGrid, false);
    if (!open)
        throw Error("needs {}, which is not beside this program: install the package metrolux-vdb", kLibrary);
    return reinterpret_cast<OpenVdbGrid>(open);
#else
    throw Error(
        "this program was built without OpenVDB: install libopenvdb-dev and build again, or convert the grid "
        "to "
        "Mitsuba's .vol");
#endif
}

VdbFile read(const std::filesystem::path& file, const std::string& name, MemoryBudget& memory) {
    const std::unique_ptr<VdbGrid> grid(loadOpenVdb()(file.c_str(), name.c_str(), memory.left()));
    VdbFile result;
    uint64_t count = 1;
    const std::array<int64_t, 3> resolution = grid->resolution();
    for (int a = 0; a < 3; ++a) {
        const int64_t n = resolution[static_cast<size_t>(a)];
        if (n < 1 || n > (1 << 30))
            throw Error("has {} voxels along axis {}, expected 1 to 2^30", n, "xyz"[a]);
        if (count > memory.left() / sizeof(float) / static_cast<uint64_t>(n))
            throw Error("{} x {} x {} voxels need more memory than is left for the scene", resolution[0],
                        resolution[1], resolution[2]);
        count *= static_cast<uint64_t>(n);
        result.samples.resolution[a] = static_cast<int>(n);
    }
    memory.take(count * sizeof(float) + gridVolumeBytes(result.samples.resolution), "the volume");
    result.samples.values.resize(count, 0.0f);
    grid->copyTo(result.samples.values.data());
    checkSamples(result.samples);
    double rows[4][4];
    const std::array<double, 16> toFile = grid->toFile();
    for (size_t i = 0; i < 16; ++i) rows[i / 4][i % 4] = toFile[i];
    result.toFile = Transform::fromRows(rows);
    return result;
}

}  // namespace

VdbFile readVdbFile(const std::filesystem::path& file, const std::string& grid, MemoryBudget* memory) {
    refuseLfsPointer(file);
    std::error_code code;
    if (!std::filesystem::is_regular_file(file, code)) throw Error("{}: cannot be read", file.string());
    MemoryBudget unlimited = MemoryBudget::unlimited();
    try {
        return read(file, grid, memory ? *memory : unlimited);
    } catch (const std::runtime_error& error) {
        throw Error("{}: {}", file.string(), error.what());
    }
}

}  // namespace metrolux::core
