#include "sandbox.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <unistd.h>

namespace metrolux::core::fuzz {

namespace fs = std::filesystem;

namespace {

fs::path memoryFolder() {
    const fs::path memory = "/dev/shm";
    return ::access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path();
}

}  // namespace

Sandbox::Sandbox() : TemporaryFolder(memoryFolder()) {}

void Sandbox::expectFiles(size_t count) const {
    const auto found = std::distance(fs::recursive_directory_iterator(path()), {});
    if (static_cast<size_t>(found) != count)
        fail(fmt::format("{} files in the sandbox, expected {}", found, count));
}

void fail(const std::string& what) {
    fmt::print(stderr, "{}\n", what);
    std::abort();
}

}  // namespace metrolux::core::fuzz
