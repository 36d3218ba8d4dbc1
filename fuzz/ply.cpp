/// Stanford PLY in its three formats.

#include "io/mesh_io.h"
#include "sandbox.h"

using namespace metrolux;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const fuzz::Sandbox sandbox;
    const auto file = sandbox.write("mesh.ply", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        MemoryBudget memory(fuzz::kMemoryBytes);
        MeshOptions options;
        options.memory = &memory;
        readPly(file, options);
    });
    return 0;
}
