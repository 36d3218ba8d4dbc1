#pragma once
#include "io/scene_loader.h"
#include "sandbox.h"
#include "scene/scene.h"

namespace metrolux::core::fuzz {

/// One input of a reader of scenes, up to the tree of the ray tracer.
inline int runScene(const char* name, const uint8_t* data, size_t size) {
    static const Sandbox sandbox;
    const auto file = sandbox.write(name, {reinterpret_cast<const char*>(data), size});
    expectErrorsOnly(file, [&] {
        LoadOptions options;
        options.memoryBytes = kMemoryBytes;
        options.lenient = size % 2 == 1;
        options.setResolution(16, 12);
        const Scene scene(loadScene(file, options));
    });
    sandbox.expectFiles(1);
    return 0;
}

}  // namespace metrolux::core::fuzz
