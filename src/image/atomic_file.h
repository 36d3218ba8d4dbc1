#pragma once
#include <filesystem>
#include <string_view>

namespace metrolux::core {

/// Replaces a file as a whole or not at all: the content goes to a temporary file in the same folder, which
/// is flushed to disk and renamed. Without commit() the temporary file is removed again.
class AtomicFile {
  public:
    /// Throws Error when the target cannot be replaced or nothing can be created beside it.
    explicit AtomicFile(const std::filesystem::path& target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Exists and is empty; to be written and closed before commit().
    const std::filesystem::path& temporary() const { return temporary_; }
    /// Throws Error when the data does not reach the disk. `previous`: name that the replaced file keeps;
    /// there is no moment without a complete file under the target's name.
    void commit(const std::filesystem::path& previous = {});

  private:
    std::filesystem::path target_, temporary_;
    bool committed_ = false;
};

/// Throws Error when a file could not be written there. Leaves no trace.
void checkWritable(const std::filesystem::path& target);
/// Removes what processes that were killed while they wrote this file have left beside it.
void removeLeftovers(const std::filesystem::path& target);
/// Throws Error.
void writeTextFile(const std::filesystem::path& target, std::string_view text);

}  // namespace metrolux::core
