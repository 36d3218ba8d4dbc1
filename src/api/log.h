#pragma once
#include <metrolux/log.h>

namespace metrolux::core::api {

/// To the receiver of setLog().
void log(LogLevel level, const std::string& message);

}  // namespace metrolux::core::api
