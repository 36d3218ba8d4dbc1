#include "render/open_image_denoise.h"

#include "base/error.h"

#include <tbb/task_arena.h>

#include <cmath>
#include <cstdlib>
#include <dlfcn.h>

namespace metrolux::core {
namespace {

constexpr const char* kVariable = "METROLUX_OIDN";

// What is needed of the C API (OpenImageDenoise/oidn.h), which is stable within a version. Version 2 has
// other names for some functions of version 1.
using Handle = void*;
constexpr int kDeviceCpu = 1;     // OIDN_DEVICE_TYPE_CPU: devices of other types may not see our memory
constexpr int kFormatFloat3 = 3;  // OIDN_FORMAT_FLOAT3

/// A library that has been loaded. It stays: libraries with threads are not made to be unloaded.
class Library {
  public:
    explicit Library(void* library, std::string file) : library_(library), file_(std::move(file)) {}
    /// Throws Error when no name is there.
    template <class Function>
    void find(Function*& function, const char* name, const char* otherName = nullptr) const {
        void* symbol = dlsym(library_, name);
        if (!symbol && otherName) symbol = dlsym(library_, otherName);
        if (!symbol)
            throw Error("'{}' is not Open Image Denoise: found no function {}{}{}", file_, name,
                        otherName ? " or " : "", otherName ? otherName : "");
        function = reinterpret_cast<Function*>(symbol);
    }

  private:
    void* library_;
    std::string file_;
};

struct Functions {
    Handle (*newDevice)(int type);
    void (*setDeviceInt)(Handle device, const char* name, int value);
    void (*setDeviceBool)(Handle device, const char* name, bool value);
    int (*getDeviceInt)(Handle device, const char* name);
    int (*getDeviceError)(Handle device, const char** message);
    void (*commitDevice)(Handle device);
    void (*releaseDevice)(Handle device);
    Handle (*newFilter)(Handle device, const char* type);
    void (*setSharedFilterImage)(Handle filter, const char* name, void* pixels, int format, size_t width,
                                 size_t height, size_t offset, size_t pixelStride, size_t rowStride);
    void (*setFilterBool)(Handle filter, const char* name, bool value);
    void (*commitFilter)(Handle filter);
    void (*executeFilter)(Handle filter);
    void (*releaseFilter)(Handle filter);

    explicit Functions(const Library& library) {
        library.find(newDevice, "oidnNewDevice");
        library.find(setDeviceInt, "oidnSetDeviceInt", "oidnSetDevice1i");
        library.find(setDeviceBool, "oidnSetDeviceBool", "oidnSetDevice1b");
        library.find(getDeviceInt, "oidnGetDeviceInt", "oidnGetDevice1i");
        library.find(getDeviceError, "oidnGetDeviceError");
        library.find(commitDevice, "oidnCommitDevice");
        library.find(releaseDevice, "oidnReleaseDevice");
        library.find(newFilter, "oidnNewFilter");
        library.find(setSharedFilterImage, "oidnSetSharedFilterImage");
        library.find(setFilterBool, "oidnSetFilterBool", "oidnSetFilter1b");
        library.find(commitFilter, "oidnCommitFilter");
        library.find(executeFilter, "oidnExecuteFilter");
        library.find(releaseFilter, "oidnReleaseFilter");
    }
};

/// A handle that is given back.
class Owned {
  public:
    Owned(Handle handle, void (*release)(Handle)) : handle_(handle), release_(release) {}
    ~Owned() {
        if (handle_) release_(handle_);
    }
    Owned(const Owned&) = delete;
    Owned& operator=(const Owned&) = delete;
    operator Handle() const { return handle_; }

  private:
    Handle handle_;
    void (*release_)(Handle);
};

class LoadedLibrary final : public OpenImageDenoise {
  public:
    explicit LoadedLibrary(const Library& library)
        : f_(library), device_(f_.newDevice(kDeviceCpu), f_.releaseDevice) {
        check();
        f_.setDeviceInt(device_, "numThreads", tbb::this_task_arena::max_concurrency());
        f_.setDeviceBool(device_, "setAffinity", false);  // other threads are at work, too
        f_.commitDevice(device_);
        check();
        version_ = f_.getDeviceInt(device_, "version");
    }

    std::vector<float> denoise(const Input& input) const override {
        std::vector<float> output(input.color.size());
        const Owned filter(f_.newFilter(device_, "RT"), f_.releaseFilter);
        check();
        const auto set = [&](const char* name, const float* pixels) {
            // The library reads its inputs only; the type of the parameter serves outputs, too.
            f_.setSharedFilterImage(filter, name, const_cast<float*>(pixels), kFormatFloat3,
                                    static_cast<size_t>(input.width), static_cast<size_t>(input.height), 0, 0,
                                    0);
        };
        set("color", input.color.data());
        set("albedo", input.albedo.data());
        set("normal", input.normal.data());
        set("output", output.data());
        f_.setFilterBool(filter, "hdr", true);
        f_.commitFilter(filter);
        f_.executeFilter(filter);
        check();
        for (const float x : output)
            if (!std::isfinite(x)) throw Error("{}: found a result that is not finite", name());
        return output;
    }

    std::string name() const override {
        return fmt::format("Open Image Denoise {}.{}.{}", version_ / 10000, version_ / 100 % 100,
                           version_ % 100);
    }

  private:
    void check() const {
        const char* message = nullptr;
        if (f_.getDeviceError(device_, &message) != 0)
            throw Error("Open Image Denoise: {}", message ? message : "an error without a message");
        if (!device_) throw Error("Open Image Denoise: found no device");
    }

    Functions f_;
    Owned device_;
    int version_ = 0;
};

}  // namespace

std::unique_ptr<OpenImageDenoise> OpenImageDenoise::load() {
    const char* const chosen = std::getenv(kVariable);
    const std::string file = chosen ? chosen : "";
    if (file == "off") return nullptr;
    if (!file.empty()) {
        void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
        if (!library) throw Error("{}: cannot load '{}': {}", kVariable, file, dlerror());
        return std::make_unique<LoadedLibrary>(Library(library, file));
    }
    for (const char* name :
         {"libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so.0"})
        if (void* library = dlopen(name, RTLD_NOW | RTLD_LOCAL))
            return std::make_unique<LoadedLibrary>(Library(library, name));
    return nullptr;
}

}  // namespace metrolux::core
