#pragma once
#include "base/printable.h"

#include <metrolux/error.h>

#include <fmt/format.h>

#include <string>
#include <type_traits>

namespace metrolux::core {

/// The library's error with its text formatted; the command prints it and exits with status 2. Text among the
/// arguments, which may come from a file, becomes printable: it cannot forge lines or steer a terminal.
class Error : public metrolux::Error {
  public:
    explicit Error(const std::string& message) : metrolux::Error(message) {}
    template <class... Args>
    explicit Error(fmt::format_string<Args...> format, Args&&... args)
        : metrolux::Error(text(format, shown(args)...)) {}

  private:
    template <class T>
    static decltype(auto) shown(const T& value) {
        if constexpr (std::is_convertible_v<const T&, std::string_view>)
            return printable(value);
        else
            return (value);
    }
    template <class... Args>
    static std::string text(fmt::string_view format, const Args&... args) {
        return fmt::vformat(format, fmt::make_format_args(args...));
    }
};

}  // namespace metrolux::core
