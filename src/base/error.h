#pragma once
#include <metrolux/error.h>

#include <fmt/format.h>

#include <string>

namespace metrolux::core {

/// The library's error with its text formatted; the command prints it and exits with status 2.
class Error : public metrolux::Error {
  public:
    explicit Error(const std::string& message) : metrolux::Error(message) {}
    template <class... Args>
    explicit Error(fmt::format_string<Args...> format, Args&&... args)
        : metrolux::Error(fmt::format(format, std::forward<Args>(args)...)) {}
};

}  // namespace metrolux::core
