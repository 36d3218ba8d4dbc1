#pragma once
#include <filesystem>

namespace metrolux::core {

/// Throws Error when the file is the pointer that Git LFS leaves in place of a file that was not fetched
/// (https://github.com/git-lfs/git-lfs/blob/main/docs/spec.md).
void refuseLfsPointer(const std::filesystem::path& file);

}  // namespace metrolux::core
