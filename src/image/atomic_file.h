#pragma once
#include <filesystem>
#include <string_view>

namespace metrolux::core {

/// Replaces a file as a whole or not at all: the content goes to a temporary file in the same folder, which
/// is flushed to disk and renamed. Without commit() the temporary file is removed again. The return value of
/// every system call counts; calls that a signal interrupts are made again.
///
/// A symbolic link stays a link, dangling or not: what it points to is replaced. A replaced file's
/// permissions are kept.
class AtomicFile {
  public:
    /// Throws Error when the target is anything but a file that may be replaced (a folder, a device, a FIFO),
    /// or nothing can be created beside it.
    explicit AtomicFile(const std::filesystem::path& target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Appends. Throws Error when the bytes cannot be written.
    void write(std::string_view bytes);
    /// Throws Error when the data does not reach the disk; then the target is what it was. `previous`: name
    /// that the replaced file keeps; there is no moment without a complete file under the target's name.
    void commit(const std::filesystem::path& previous = {});
    /// As commit(), but never replaces: false when the target exists by now.
    bool commitNew();

  private:
    void closeFlushed();
    void flushFolder() const;
    [[noreturn]] void fail(int error) const;

    std::filesystem::path target_, temporary_;
    int descriptor_ = -1;
    bool committed_ = false;
};

/// Throws Error when a file could not be written there. Leaves no trace.
void checkWritable(const std::filesystem::path& target);
/// The file that is replaced when `target` is written: links are followed, the last one even if it dangles.
std::filesystem::path followLinks(const std::filesystem::path& target);
/// Removes what processes that were killed while they wrote this file have left beside it.
void removeLeftovers(const std::filesystem::path& target);
/// Replaces a file by these bytes, as AtomicFile does. Throws Error.
void writeFile(const std::filesystem::path& target, std::string_view bytes);

}  // namespace metrolux::core
