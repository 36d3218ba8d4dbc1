#pragma once
#include "io/mesh_io.h"
#include "sandbox.h"

namespace metrolux::core::fuzz {

/// One input of a reader of mesh files: readMesh(file, options).
template <class Read>
int runMesh(const char* name, const uint8_t* data, size_t size, Read&& readMesh) {
    static const Sandbox sandbox;
    const auto file = sandbox.write(name, {reinterpret_cast<const char*>(data), size});
    expectErrorsOnly(file, [&] {
        MemoryBudget memory(kMemoryBytes);
        MeshOptions options;
        options.memory = &memory;
        readMesh(file, options);
    });
    return 0;
}

}  // namespace metrolux::core::fuzz
