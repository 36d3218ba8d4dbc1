#pragma once
/// What the targets share: a folder for the files that a parser is to read, and what counts as a good end.

#include "base/error.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace metrolux::fuzz {

/// A folder of this process, in memory where the system has such a place; removed at exit.
class Sandbox {
  public:
    Sandbox();
    ~Sandbox();
    Sandbox(const Sandbox&) = delete;
    Sandbox& operator=(const Sandbox&) = delete;

    std::filesystem::path write(const std::string& name, std::string_view bytes) const;
    std::filesystem::path path(const std::string& name) const { return folder_ / name; }
    /// Ends the process if there is another file than those that were written: no input may make the parsers
    /// write.
    void expectFiles(size_t count) const;

  private:
    std::filesystem::path folder_;
};

/// What a target may take for one input.
inline constexpr uint64_t kMemoryBytes = uint64_t{256} << 20;

/// Ends the process, with a message.
[[noreturn]] void fail(const std::string& what);

/// Runs a parser of `file`. It may succeed or throw Error, with a message that names a file of the folder;
/// everything else ends the process.
template <class Parse>
void expectErrorsOnly(const std::filesystem::path& file, Parse&& parse) {
    try {
        parse();
    } catch (const Error& error) {
        const std::string message = error.what();
        if (message.find(file.parent_path().string()) == std::string::npos)
            fail("an error that names no file: " + message);
    }
}

}  // namespace metrolux::fuzz
