#pragma once
#include <filesystem>
#include <string>

namespace metrolux::core {

/// Keeps other processes from writing the same file for as long as it lives: two renderings with one output
/// would overwrite each other's images in turn, and with one checkpoint lose one of the two. The lock is
/// flock(2) on a hidden file beside the target, which the system frees when the process ends in whatever way.
/// Where a file system has no locks, or nothing can be created, there is none: that is no reason not to
/// render.
class FileLock {
  public:
    /// Throws Error when another process has the lock. `what` names the file for people.
    FileLock(const std::string& what, const std::filesystem::path& target);
    ~FileLock();
    FileLock(FileLock&& other) noexcept;
    FileLock& operator=(FileLock&&) = delete;
    FileLock(const FileLock&) = delete;
    FileLock& operator=(const FileLock&) = delete;

  private:
    std::filesystem::path file_;
    int descriptor_ = -1;
};

}  // namespace metrolux::core
