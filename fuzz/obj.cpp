/// Wavefront OBJ.

#include "io/mesh_io.h"
#include "sandbox.h"

using namespace metrolux;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const fuzz::Sandbox sandbox;
    const auto file = sandbox.write("mesh.obj", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        MemoryBudget memory(fuzz::kMemoryBytes);
        MeshOptions options;
        options.memory = &memory;
        readObj(file, options);
    });
    return 0;
}
