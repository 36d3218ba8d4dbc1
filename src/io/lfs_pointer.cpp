#include "io/lfs_pointer.h"

#include "base/error.h"

#include <fstream>
#include <string>

namespace metrolux::core {

void refuseLfsPointer(const std::filesystem::path& file) {
    constexpr std::string_view kBegin = "version https://git-lfs.github.com/spec/";
    std::string text(kBegin.size(), '\0');
    std::ifstream stream(file, std::ios::binary);
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (stream && text == kBegin)
        throw Error("{}: found a pointer of Git LFS, expected the file itself; fetch it with `git lfs pull`",
                    file.string());
}

}  // namespace metrolux::core
