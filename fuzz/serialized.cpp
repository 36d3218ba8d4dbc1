/// Mitsuba's compressed meshes: the first mesh of a file, or the second where its size is odd.

#include "io/mesh_io.h"
#include "sandbox.h"

using namespace metrolux;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const fuzz::Sandbox sandbox;
    const auto file = sandbox.write("mesh.serialized", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        MemoryBudget memory(fuzz::kMemoryBytes);
        MeshOptions options;
        options.memory = &memory;
        readSerialized(file, size % 2 == 0 ? 0 : 1, options);
    });
    return 0;
}
