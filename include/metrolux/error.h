#pragma once
#include <metrolux/export.h>

#include <stdexcept>
#include <string>

namespace metrolux {

/// Something that was given cannot be used. The message names the file, line, element or parameter, what was
/// found and what was expected: the text that the command prints.
class METROLUX_API Error : public std::runtime_error {
  public:
    explicit Error(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace metrolux
