/// Stands in for Open Image Denoise, which is not in the distribution: the entry points of version 2 that we
/// call. Its filter mixes what it was given, so that a test sees that all of it has arrived. FAKE_OIDN=fail:
/// the filter fails.

#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace {

struct Image {
    float* pixels = nullptr;
    size_t width = 0, height = 0;
};
struct Filter {
    Image color, albedo, normal, output;
    bool hdr = false, committed = false;
};

const char* error = nullptr;
int device;

/// Of images without strides of their own, and of 3 floats.
bool isPlain(int format, size_t offset, size_t pixelStride, size_t rowStride) {
    return format == 3 && offset == 0 && pixelStride == 0 && rowStride == 0;
}

}  // namespace

#define EXPORT extern "C" __attribute__((visibility("default")))

EXPORT void* oidnNewDevice(int type) {
    if (type != 1) error = "the stand-in has a CPU only";
    return &device;
}
EXPORT void oidnSetDeviceInt(void*, const char* name, int value) {
    if (std::strcmp(name, "numThreads") != 0 || value < 1) error = "an unknown number";
}
EXPORT void oidnSetDeviceBool(void*, const char* name, bool) {
    if (std::strcmp(name, "setAffinity") != 0) error = "an unknown flag";
}
EXPORT int oidnGetDeviceInt(void*, const char* name) { return std::strcmp(name, "version") == 0 ? 20304 : 0; }
EXPORT int oidnGetDeviceError(void*, const char** message) {
    if (!error) return 0;
    *message = error;
    error = nullptr;
    return 1;
}
EXPORT void oidnCommitDevice(void*) {}
EXPORT void oidnReleaseDevice(void*) {}

EXPORT void* oidnNewFilter(void*, const char* type) {
    if (std::strcmp(type, "RT") != 0) error = "an unknown filter";
    return new Filter;
}
EXPORT void oidnSetSharedFilterImage(void* handle, const char* name, void* pixels, int format, size_t width,
                                     size_t height, size_t offset, size_t pixelStride, size_t rowStride) {
    auto* filter = static_cast<Filter*>(handle);
    if (!isPlain(format, offset, pixelStride, rowStride)) error = "an image of another shape";
    const Image image{static_cast<float*>(pixels), width, height};
    if (std::strcmp(name, "color") == 0) filter->color = image;
    if (std::strcmp(name, "albedo") == 0) filter->albedo = image;
    if (std::strcmp(name, "normal") == 0) filter->normal = image;
    if (std::strcmp(name, "output") == 0) filter->output = image;
}
EXPORT void oidnSetFilterBool(void* handle, const char* name, bool value) {
    if (std::strcmp(name, "hdr") == 0) static_cast<Filter*>(handle)->hdr = value;
}
EXPORT void oidnCommitFilter(void* handle) { static_cast<Filter*>(handle)->committed = true; }
EXPORT void oidnExecuteFilter(void* handle) {
    const auto* filter = static_cast<Filter*>(handle);
    const char* wish = std::getenv("FAKE_OIDN");
    if (wish && std::strcmp(wish, "fail") == 0) error = "the stand-in was to fail";
    const Image& out = filter->output;
    if (!filter->hdr || !filter->committed || !filter->color.pixels || !filter->albedo.pixels ||
        !filter->normal.pixels || !out.pixels)
        error = "something is missing";
    if (error) return;
    for (size_t i = 0; i < 3 * out.width * out.height; ++i)
        out.pixels[i] = filter->color.pixels[i] + 10 * filter->albedo.pixels[i] +
                        (filter->normal.pixels[i] != 0 ? 100.0f : 0.0f);
}
EXPORT void oidnReleaseFilter(void* handle) { delete static_cast<Filter*>(handle); }
