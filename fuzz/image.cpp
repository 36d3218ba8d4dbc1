/// Images of all formats: the first byte chooses the file's extension, the rest is the file.

#include "image/image_io.h"
#include "sandbox.h"

using namespace metrolux::core;

namespace {
constexpr const char* kNames[] = {"a.exr", "a.png", "a.jpg",  "a.hdr", "a.bmp",
                                  "a.tga", "a.pfm", "a.tiff", "a.ppm", "a.avi"};
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    if (size == 0) return 0;
    static const fuzz::Sandbox sandbox;
    const char* name = kNames[data[0] % std::size(kNames)];
    const auto file = sandbox.write(name, {reinterpret_cast<const char*>(data + 1), size - 1});
    fuzz::expectErrorsOnly(file, [&] {
        MemoryBudget memory(fuzz::kMemoryBytes);
        const ImageData image = readImage(file, data[0] >= 128, &memory);
        const size_t values = size_t(image.width) * size_t(image.height) * size_t(image.channels);
        if (image.pixels.size() != values) fuzz::fail("an image of another size than it says");
    });
    fuzz::expectErrorsOnly(file, [&] { readMetadata(file); });
    std::filesystem::remove(file);
    return 0;
}
