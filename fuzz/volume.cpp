/// Mitsuba's grids, and rays through what is made of them.

#include "io/volume_file.h"
#include "sandbox.h"

using namespace metrolux::core;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const fuzz::Sandbox sandbox;
    const auto file = sandbox.write("grid.vol", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        MemoryBudget memory(fuzz::kMemoryBytes);
        VolumeFile volume = readVolumeFile(file, &memory);
        // Some settings of every kind, by the size of the file.
        GridSettings settings;
        settings.filter = size % 2 == 0 ? GridFilter::Trilinear : GridFilter::Nearest;
        settings.wrap = static_cast<GridWrap>(size % 3);
        settings.toWorld = Transform::rotate({1, 2, 3}, size % 5 == 0 ? 30 : 0);
        const VolumePtr grid = makeGridVolume(std::move(volume.samples), settings);
        const Vec3f origin(-0.1f, 0.3f, -0.2f);
        for (const Vec3f& direction : {normalize(Vec3f(1, 0.4f, 0.9f)), Vec3f(1, 0, 0)}) {
            const Rgb whole = grid->integral(origin, direction, 0, 2);
            if (!(whole.x >= 0)) fuzz::fail("an integral that is negative");
            const auto crossing = grid->cross(origin, direction, 0, 2, 0, 0.5 * double(whole.x));
            if (crossing && !(crossing->distance >= 0 && crossing->distance <= 2))
                fuzz::fail("a crossing that is beyond its segment");
        }
    });
    return 0;
}
