/// Whole scenes, with meshes, images, spectra and includes in reach, up to the tree of the ray tracer.

#include "scene/scene.h"

#include "image/image_io.h"
#include "io/scene_loader.h"
#include "sandbox.h"

using namespace metrolux::core;

namespace {

constexpr size_t kFiles = 6;

/// The folder with what the scenes of the corpus refer to.
const fuzz::Sandbox& sandbox() {
    static const fuzz::Sandbox folder;
    static const bool filled = [] {
        folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        folder.write(
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            "property float z\nproperty float weight\nelement face 1\n"
            "property list uchar int vertex_index\nend_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n");
        folder.write("a.spd", "400 0.5\n700 0.8\n");
        folder.write("part.xml", "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"included\"/></scene>");
        writePngRaw(folder.path() / "a.png", {2, 1, 3, {0, 0.5f, 1, 1, 0.5f, 0}});
        return true;
    }();
    (void)filled;
    return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const auto file = sandbox().write("scene.xml", {reinterpret_cast<const char*>(data), size});
    fuzz::expectErrorsOnly(file, [&] {
        LoadOptions options;
        options.memoryBytes = fuzz::kMemoryBytes;
        options.lenient = size % 2 == 1;
        const Scene scene(loadScene(file, options));
    });
    sandbox().expectFiles(kFiles);
    return 0;
}
