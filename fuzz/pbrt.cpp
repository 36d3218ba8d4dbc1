/// pbrt scenes, up to the tree of the ray tracer.

#include "io/scene_loader.h"
#include "sandbox.h"
#include "scene/scene.h"

using namespace metrolux::core;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const fuzz::Sandbox sandbox;
    const auto file = sandbox.write("scene.pbrt", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        LoadOptions options;
        options.memoryBytes = fuzz::kMemoryBytes;
        options.lenient = size % 2 == 1;
        options.setResolution(16, 12);
        const Scene scene(loadScene(file, options));
    });
    sandbox.expectFiles(1);
    return 0;
}
