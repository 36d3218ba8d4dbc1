/// A library to be loaded before others (LD_PRELOAD): one call of the operating system that concerns a file
/// in a folder fails. Environment:
///
///     FAILING_IO_FOLDER  files below it are concerned (absolute, no links)
///     FAILING_IO_CALL    number of the call that fails, from 1; 0: none
///     FAILING_IO_ERRNO   what it fails with
///     FAILING_IO_STAYS   set: every later write fails too, as on a full disk
///     FAILING_IO_LOG     file that gets a line for each call: its number, name and path

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

int calls = 0;

template <class Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

bool concerned(const char* path) {
    const char* folder = std::getenv("FAILING_IO_FOLDER");
    if (!folder || !path) return false;
    char absolute[4096];
    if (path[0] != '/') {
        if (!::getcwd(absolute, sizeof absolute)) return false;
        const size_t used = std::strlen(absolute);
        std::snprintf(absolute + used, sizeof absolute - used, "/%s", path);
        path = absolute;
    }
    return std::strncmp(path, folder, std::strlen(folder)) == 0;
}

void log(const char* name, const char* path) {
    const char* file = std::getenv("FAILING_IO_LOG");
    if (!file) return;
    char line[4400];
    const int length = std::snprintf(line, sizeof line, "%d %s %s\n", calls, name, path);
    const long descriptor = ::syscall(SYS_openat, AT_FDCWD, file, O_WRONLY | O_CREAT | O_APPEND, 0666);
    ::syscall(SYS_write, descriptor, line, length);
    ::syscall(SYS_close, descriptor);
}

/// Whether this call is to fail, with errno set.
bool fails(const char* name, const char* path) {
    if (!concerned(path)) return false;
    ++calls;
    log(name, path);
    const int chosen = std::atoi(std::getenv("FAILING_IO_CALL"));
    const bool stays = std::getenv("FAILING_IO_STAYS") && std::strcmp(name, "write") == 0;
    if (chosen == 0 || (calls != chosen && !(stays && calls > chosen))) return false;
    errno = std::atoi(std::getenv("FAILING_IO_ERRNO"));
    return true;
}

bool failsOn(const char* name, int descriptor) {
    char link[64], path[4096];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t length = ::readlink(link, path, sizeof path - 1);
    if (length <= 0) return false;
    path[length] = 0;
    // Files that are only read are none of our business.
    const int flags = ::fcntl(descriptor, F_GETFL);
    if ((flags & O_ACCMODE) == O_RDONLY && !(flags & O_DIRECTORY)) return false;
    return fails(name, path);
}

int opened(const char* name, const char* path, int flags, mode_t mode) {
    const bool writes = (flags & O_ACCMODE) != O_RDONLY;
    if (writes && fails("open", path)) return -1;
    return next<int(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = (flags & O_CREAT) ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return opened("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = (flags & O_CREAT) ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return opened("open64", path, flags, mode);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
    if (failsOn("write", descriptor)) return -1;
    return next<ssize_t(int, const void*, size_t)>("write")(descriptor, bytes, size);
}

int fsync(int descriptor) {
    if (failsOn("fsync", descriptor)) return -1;
    return next<int(int)>("fsync")(descriptor);
}

int close(int descriptor) {
    // A descriptor is gone even when close(2) reports an error.
    const bool failed = failsOn("close", descriptor);
    const int error = errno;
    const int result = next<int(int)>("close")(descriptor);
    if (!failed) return result;
    errno = error;
    return -1;
}

int rename(const char* from, const char* to) {
    if (fails("rename", to)) return -1;
    return next<int(const char*, const char*)>("rename")(from, to);
}

int link(const char* from, const char* to) {
    if (fails("link", to)) return -1;
    return next<int(const char*, const char*)>("link")(from, to);
}

int unlink(const char* path) {
    if (fails("unlink", path)) return -1;
    return next<int(const char*)>("unlink")(path);
}

int remove(const char* path) {
    if (fails("remove", path)) return -1;
    return next<int(const char*)>("remove")(path);
}
}
