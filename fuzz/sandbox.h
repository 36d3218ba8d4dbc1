#pragma once
/// What the targets share: a folder for the files that a parser is to read, and what counts as a good end.

#include "base/error.h"
#include "support/temporary_folder.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace metrolux::core::fuzz {

/// A folder of this process, in memory where the system has such a place; removed at exit.
class Sandbox : public test::TemporaryFolder {
  public:
    Sandbox();
    /// Ends the process if there is another file than those that were written: no input may make the parsers
    /// write.
    void expectFiles(size_t count) const;
};

/// What a target may take for one input.
inline constexpr uint64_t kMemoryBytes = uint64_t{256} << 20;

/// Ends the process, with a message.
[[noreturn]] void fail(const std::string& what);

/// Runs a parser. It may succeed or throw Error, with a message that contains `name`; everything else ends
/// the process.
template <class Parse>
void expectErrorsOnly(const std::string& name, Parse&& parse) {
    try {
        parse();
    } catch (const Error& error) {
        const std::string message = error.what();
        if (message.find(name) == std::string::npos) fail("an error that names no file: " + message);
    }
}
/// Of a file: the message has to name one of its folder.
template <class Parse>
void expectErrorsOnly(const std::filesystem::path& file, Parse&& parse) {
    expectErrorsOnly(file.parent_path().string(), std::forward<Parse>(parse));
}

}  // namespace metrolux::core::fuzz
