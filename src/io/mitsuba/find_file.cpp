#include "io/lfs_pointer.h"
#include "io/mitsuba/parser.h"

#include <algorithm>

namespace metrolux::core::mitsuba {

namespace fs = std::filesystem;

fs::path findFile(const std::string& filename, const fs::path& from,
                  const std::vector<fs::path>& searchPaths) {
    if (filename.empty()) throw Error("found an empty file name");
    std::string name = filename;
    if (name.find('\0') != std::string::npos || name.size() > 4096)
        throw Error("found an unusable file name");
    std::vector<fs::path> folders;
    const auto add = [&folders](const fs::path& folder) {
        if (std::find(folders.begin(), folders.end(), folder) == folders.end()) folders.push_back(folder);
    };
    if (!fs::path(name).is_absolute()) {
        const fs::path own = from.parent_path();
        if (searchPaths.empty() || own != searchPaths.back()) add(own);
        for (const fs::path& folder : searchPaths) add(folder);
    }
    add({});  // absolute, or in the working folder
    bool foundFolder = false;
    for (int attempt = 0; attempt < 2; ++attempt) {
        for (const fs::path& folder : folders) {
            std::error_code code;
            const fs::path candidate = folder / name;
            if (fs::is_regular_file(candidate, code)) {
                refuseLfsPointer(candidate);
                return candidate;
            }
            foundFolder = foundFolder || fs::is_directory(candidate, code);
        }
        std::replace(name.begin(), name.end(), '\\', '/');  // scenes exported on Windows
    }
    std::string places;
    for (const fs::path& folder : folders)
        places += (places.empty() ? "" : ", ") + (folder.empty() ? std::string(".") : folder.string());
    if (foundFolder) throw Error("\"{}\" is a folder, expected a file", filename);
    throw Error("the file \"{}\" does not exist (looked in: {})", filename, places);
}

}  // namespace metrolux::core::mitsuba
