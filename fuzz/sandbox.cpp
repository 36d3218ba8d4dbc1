#include "sandbox.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <unistd.h>

namespace metrolux::fuzz {

namespace fs = std::filesystem;

Sandbox::Sandbox() {
    const fs::path memory = "/dev/shm";
    const fs::path parent = ::access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path();
    std::string pattern = (parent / "metrolux_fuzz_XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("cannot make a folder in " + parent.string());
    folder_ = pattern;
}

Sandbox::~Sandbox() {
    std::error_code code;
    fs::remove_all(folder_, code);
}

fs::path Sandbox::write(const std::string& name, std::string_view bytes) const {
    fs::path file = folder_ / name;
    std::ofstream stream(file, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) throw std::runtime_error("cannot write " + file.string());
    return file;
}

void Sandbox::expectFiles(size_t count) const {
    const auto found = std::distance(fs::recursive_directory_iterator(folder_), {});
    if (static_cast<size_t>(found) != count)
        fail(fmt::format("{} files in the sandbox, expected {}", found, count));
}

void fail(const std::string& what) {
    fmt::print(stderr, "{}\n", what);
    std::abort();
}

}  // namespace metrolux::fuzz
