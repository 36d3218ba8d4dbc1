#include "base/loaded_library.h"

#include "base/error.h"

#include <dlfcn.h>
#include <filesystem>
#include <vector>

namespace metrolux::core {
namespace {

/// Folders in which libraries may be: where this code is, and where it is installed.
std::vector<std::filesystem::path> libraryFolders() {
    std::vector<std::filesystem::path> result;
    std::error_code code;
    std::vector<std::filesystem::path> objects{std::filesystem::read_symlink("/proc/self/exe", code)};
    static const char kHere = 0;
    Dl_info object{};
    if (dladdr(&kHere, &object) != 0 && object.dli_fname) objects.emplace_back(object.dli_fname);
    for (const std::filesystem::path& path : objects) {
        const std::filesystem::path folder = path.parent_path();
        if (folder.empty()) continue;  // a command's name as it was typed
        for (const char* beside : {".", "metrolux", METROLUX_LIBRARIES_FROM_COMMAND})
            result.push_back(folder / beside);
    }
    return result;
}

}  // namespace

void* loadFunction(const char* library, const char* symbol, bool isGlobal) {
    for (const std::filesystem::path& folder : libraryFolders()) {
        std::error_code code;
        const std::filesystem::path file = folder / library;
        if (!std::filesystem::exists(file, code)) continue;
        void* const handle = dlopen(file.c_str(), RTLD_NOW | (isGlobal ? RTLD_GLOBAL : RTLD_LOCAL));
        void* const function = handle ? dlsym(handle, symbol) : nullptr;
        if (!function) throw Error("cannot load '{}': {}", file.string(), dlerror());
        return function;
    }
    return nullptr;
}

}  // namespace metrolux::core
