#pragma once
#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace metrolux::core {

/// Something that the user gave cannot be used. The message names the file, the line or element, what was
/// found and what was expected; the command prints it and exits with status 2.
class Error : public std::runtime_error {
  public:
    explicit Error(const std::string& message) : std::runtime_error(message) {}
    template <class... Args>
    explicit Error(fmt::format_string<Args...> format, Args&&... args)
        : std::runtime_error(fmt::format(format, std::forward<Args>(args)...)) {}
};

}  // namespace metrolux::core
