#include "image/atomic_file.h"

#include "base/error.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

/// Makes a system call again for as long as a signal interrupts it.
template <class Call>
auto retried(Call&& call) {
    auto result = call();
    while (result < 0 && errno == EINTR) result = call();
    return result;
}

/// Linux closes the descriptor even when a signal interrupts the call.
int closeOnce(int descriptor) { return ::close(descriptor) < 0 && errno != EINTR ? -1 : 0; }

fs::path folderOf(const fs::path& file) {
    const fs::path folder = file.parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

/// rename(2), with errno as the result.
int renameFile(const fs::path& from, const fs::path& to) {
    return retried([&] { return ::rename(from.c_str(), to.c_str()); }) == 0 ? 0 : errno;
}

/// Gives a file a second name, in place of what had it.
void keepAs(const fs::path& file, const fs::path& name) {
    const fs::path link =
        folderOf(file) / fmt::format(".{}.{}-link.tmp", file.filename().string(), ::getpid());
    std::error_code code;
    fs::remove(link, code);
    int error = retried([&] { return ::link(file.c_str(), link.c_str()); }) == 0 ? 0 : errno;
    if (error != 0) {
        // Some network and removable file systems have no links.
        fs::copy_file(file, link, code);
        error = code.value();
    }
    if (error == 0) error = renameFile(link, name);
    // rename(2) does nothing where `name` is the same file already: a process was killed between this and the
    // commit.
    std::error_code ignored;
    fs::remove(link, ignored);
    if (error != 0) throw Error("cannot write '{}': {}", name.string(), std::strerror(error));
}

/// What stands at a path that is to be replaced must be a file, or nothing.
void checkReplaceable(const fs::path& target, const fs::path& named) {
    struct stat status {};
    if (::stat(target.c_str(), &status) != 0) return;
    const char* kind = S_ISDIR(status.st_mode)    ? "a folder"
                       : S_ISCHR(status.st_mode)  ? "a device"
                       : S_ISBLK(status.st_mode)  ? "a device"
                       : S_ISFIFO(status.st_mode) ? "a FIFO"
                       : S_ISSOCK(status.st_mode) ? "a socket"
                                                  : nullptr;
    if (kind) throw Error("cannot write '{}': it is {}, expected a file", named.string(), kind);
    if (::access(target.c_str(), W_OK) != 0)
        throw Error("cannot write '{}': {}", named.string(), std::strerror(errno));
}

}  // namespace

fs::path followLinks(const fs::path& target) {
    constexpr int kMostLinks = 40;  // as Linux
    fs::path file = target;
    for (int i = 0; i < kMostLinks; ++i) {
        std::error_code code;
        if (!fs::is_symlink(file, code)) return file;
        const fs::path next = fs::read_symlink(file, code);
        if (code) return file;
        file = next.is_absolute() ? next : folderOf(file) / next;
    }
    throw Error("cannot write '{}': more than {} links", target.string(), kMostLinks);
}

AtomicFile::AtomicFile(const fs::path& target) : target_(followLinks(target)) {
    if (target.filename().empty())
        throw Error("cannot write '{}': it names a folder, expected a file", target.string());
    checkReplaceable(target_, target);
    const fs::path folder = folderOf(target_);
    std::error_code code;
    if (!fs::is_directory(folder, code))
        throw Error("cannot write '{}': there is no folder '{}'", target.string(), folder.string());

    static std::atomic<unsigned> counter{0};
    temporary_ = folder / fmt::format(".{}.{}-{}.tmp", target_.filename().string(), ::getpid(), counter++);
    descriptor_ =
        retried([&] { return ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); });
    if (descriptor_ < 0) {
        const int error = errno;
        temporary_.clear();
        throw Error("cannot write '{}': {}", target.string(), std::strerror(error));
    }
    struct stat before {};
    // Permissions that cannot be kept (another owner's file in a shared folder) are no reason to lose an
    // image.
    if (::stat(target_.c_str(), &before) == 0) (void)::fchmod(descriptor_, before.st_mode & 07777);
}

AtomicFile::~AtomicFile() {
    if (descriptor_ >= 0) closeOnce(descriptor_);
    std::error_code ignored;
    if (!committed_ && !temporary_.empty()) fs::remove(temporary_, ignored);
}

void AtomicFile::fail(int error) const {
    throw Error("cannot write '{}': {}", target_.string(), std::strerror(error));
}

void AtomicFile::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = retried([&] { return ::write(descriptor_, bytes.data(), bytes.size()); });
        if (written < 0) fail(errno);
        if (written == 0) fail(EIO);
        bytes.remove_prefix(static_cast<size_t>(written));
    }
}

void AtomicFile::closeFlushed() {
    if (retried([&] { return ::fsync(descriptor_); }) < 0) fail(errno);
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (closeOnce(descriptor) < 0) fail(errno);
}

void AtomicFile::flushFolder() const {
    // The name is on disk once its folder is. Some file systems cannot open or flush folders; the file is in
    // its place anyway.
    const int folder =
        retried([&] { return ::open(folderOf(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
    if (folder < 0) return;
    (void)retried([&] { return ::fsync(folder); });
    closeOnce(folder);
}

void AtomicFile::commit(const fs::path& previous) {
    closeFlushed();
    std::error_code code;
    if (!previous.empty() && fs::exists(target_, code)) keepAs(target_, previous);
    if (const int error = renameFile(temporary_, target_); error != 0) fail(error);
    committed_ = true;
    flushFolder();
}

bool AtomicFile::commitNew() {
    closeFlushed();
    const int done = retried([&] { return ::link(temporary_.c_str(), target_.c_str()); });
    if (done < 0 && errno == EEXIST) return false;
    if (done < 0) fail(errno);
    flushFolder();
    return true;  // the temporary name goes with this object
}

void checkWritable(const fs::path& target) { const AtomicFile probe(target); }

void removeLeftovers(const fs::path& target) {
    const fs::path file = followLinks(target);
    const std::string prefix = fmt::format(".{}.", file.filename().string());
    std::error_code code;
    for (const fs::directory_entry& entry : fs::directory_iterator(folderOf(file), code)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(prefix) || !name.ends_with(".tmp")) continue;
        // .NAME.PROCESS-NUMBER.tmp
        const int process = std::atoi(name.c_str() + prefix.size());
        std::error_code ignored;
        if (process > 0 && ::kill(process, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), ignored);
    }
}

void writeFile(const fs::path& target, std::string_view bytes) {
    AtomicFile file(target);
    file.write(bytes);
    file.commit();
}

}  // namespace metrolux::core
