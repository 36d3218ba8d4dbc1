#include "image/atomic_file.h"

#include "base/error.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>

namespace metrolux::core {
namespace {

namespace fs = std::filesystem;

/// Flushes a file or folder to disk; false with errno set.
bool flush(const fs::path& path, int flags) {
    const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
    if (descriptor < 0) return false;
    const bool done = ::fsync(descriptor) == 0;
    const int error = errno;
    ::close(descriptor);
    errno = error;
    return done;
}

fs::path folderOf(const fs::path& file) {
    const fs::path folder = file.parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

/// Gives a file a second name, in place of what had it.
void keepAs(const fs::path& file, const fs::path& name) {
    const fs::path link =
        folderOf(file) / fmt::format(".{}.{}-link.tmp", file.filename().string(), ::getpid());
    std::error_code code;
    fs::remove(link, code);
    fs::create_hard_link(file, link, code);
    // Some network and removable file systems have no links.
    if (code) fs::copy_file(file, link, code);
    if (!code) fs::rename(link, name, code);
    // rename(2) does nothing where `name` is the same file already: a process was killed between this and the
    // commit.
    std::error_code ignored;
    fs::remove(link, ignored);
    if (code) throw Error("cannot write '{}': {}", name.string(), code.message());
}

}  // namespace

AtomicFile::AtomicFile(const fs::path& target) : target_(target) {
    if (target.filename().empty())
        throw Error("cannot write '{}': it names a folder, expected a file", target.string());
    std::error_code code;
    // A link stays a link: what it points to is replaced.
    if (fs::is_symlink(target, code)) {
        const fs::path resolved = fs::weakly_canonical(target, code);
        if (!code) target_ = resolved;
    }
    if (fs::is_directory(target_, code)) throw Error("cannot write '{}': it is a folder", target.string());
    if (fs::exists(target_, code) && ::access(target_.c_str(), W_OK) != 0)
        throw Error("cannot write '{}': {}", target.string(), std::strerror(errno));
    const fs::path folder = folderOf(target_);
    if (!fs::is_directory(folder, code))
        throw Error("cannot write '{}': there is no folder '{}'", target.string(), folder.string());

    static std::atomic<unsigned> counter{0};
    temporary_ = folder / fmt::format(".{}.{}-{}.tmp", target_.filename().string(), ::getpid(), counter++);
    const int descriptor = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0) {
        const int error = errno;
        temporary_.clear();
        throw Error("cannot write '{}': {}", target.string(), std::strerror(error));
    }
    ::close(descriptor);
}

AtomicFile::~AtomicFile() {
    std::error_code ignored;
    if (!committed_ && !temporary_.empty()) fs::remove(temporary_, ignored);
}

void AtomicFile::commit(const fs::path& previous) {
    if (!flush(temporary_, O_RDONLY))
        throw Error("cannot write '{}': {}", target_.string(), std::strerror(errno));
    std::error_code code;
    if (!previous.empty() && fs::exists(target_, code)) keepAs(target_, previous);
    fs::rename(temporary_, target_, code);
    if (code) throw Error("cannot write '{}': {}", target_.string(), code.message());
    committed_ = true;
    // The name is on disk once its folder is; some file systems cannot flush folders, and the file is there
    // anyway.
    flush(folderOf(target_), O_RDONLY | O_DIRECTORY);
}

void checkWritable(const fs::path& target) { const AtomicFile probe(target); }

void removeLeftovers(const fs::path& target) {
    const std::string prefix = fmt::format(".{}.", target.filename().string());
    std::error_code code;
    for (const fs::directory_entry& entry : fs::directory_iterator(folderOf(target), code)) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with(prefix) || !name.ends_with(".tmp")) continue;
        // .NAME.PROCESS-NUMBER.tmp
        const int process = std::atoi(name.c_str() + prefix.size());
        std::error_code ignored;
        if (process > 0 && ::kill(process, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), ignored);
    }
}

void writeTextFile(const fs::path& target, std::string_view text) {
    AtomicFile file(target);
    std::ofstream stream(file.temporary(), std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) throw Error("cannot write '{}': {}", target.string(), std::strerror(errno));
    file.commit();
}

}  // namespace metrolux::core
