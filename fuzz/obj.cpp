/// Wavefront OBJ.

#include "mesh_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return metrolux::core::fuzz::runMesh("mesh.obj", data, size, metrolux::core::readObj);
}
