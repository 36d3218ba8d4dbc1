#pragma once
#include "view/board.h"

#include <string_view>

namespace metrolux::core::view {

/// A command as pages send it: a JSON object with "do", which is the name of the command, and its arguments.
/// Throws Error that says what was found and what was expected.
Command commandFromText(std::string_view text);

}  // namespace metrolux::core::view
