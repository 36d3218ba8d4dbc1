#include "image/file_lock.h"

#include "base/error.h"
#include "image/atomic_file.h"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace metrolux::core {
namespace {

/// Whether the file of a descriptor still has its name: who had the lock before removes it.
bool isStillThere(int descriptor, const std::filesystem::path& file) {
    struct stat locked {
    }, named{};
    return ::fstat(descriptor, &locked) == 0 && ::stat(file.c_str(), &named) == 0 &&
           locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
}

/// What the process that has the lock has written: its number.
std::string ownerOf(int descriptor) {
    std::array<char, 32> text{};
    const ssize_t size = ::pread(descriptor, text.data(), text.size(), 0);
    return size > 0 ? fmt::format(" ({})", std::string(text.data(), static_cast<size_t>(size))) : "";
}

void writeOwner(const std::filesystem::path& file) {
    const std::string owner = fmt::format("process {}", ::getpid());
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
    if (descriptor < 0) return;
    (void)!::write(descriptor, owner.data(), owner.size());
    ::close(descriptor);
}

}  // namespace

FileLock::FileLock(const std::string& what, const std::filesystem::path& target) {
    const std::filesystem::path replaced = followLinks(target);
    file_ = replaced.parent_path() / fmt::format(".{}.lock", replaced.filename().string());
    constexpr int kTries = 100;
    for (int i = 0; i < kTries; ++i) {
        // Not open for writing: that would keep the file system from being made read-only.
        descriptor_ = ::open(file_.c_str(), O_RDONLY | O_CREAT | O_CLOEXEC, 0666);
        if (descriptor_ < 0) return;
        if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
            const int error = errno;
            const std::string owner = ownerOf(descriptor_);
            ::close(std::exchange(descriptor_, -1));
            if (error != EWOULDBLOCK) return;
            throw Error("{} is being written by another process{}: name another file, or wait for it", what,
                        owner);
        }
        if (isStillThere(descriptor_, file_)) {
            writeOwner(file_);
            return;
        }
        ::close(std::exchange(descriptor_, -1));
    }
}

FileLock::FileLock(FileLock&& other) noexcept
    : file_(std::move(other.file_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock::~FileLock() {
    if (descriptor_ < 0) return;
    ::unlink(file_.c_str());
    ::close(descriptor_);
}

}  // namespace metrolux::core
