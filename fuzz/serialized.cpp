/// Mitsuba's compressed meshes: the first mesh of a file, or the second where its size is odd.

#include "mesh_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return metrolux::core::fuzz::runMesh(
        "mesh.serialized", data, size, [size](const auto& file, const auto& options) {
            metrolux::core::readSerialized(file, size % 2 == 0 ? 0 : 1, options);
        });
}
