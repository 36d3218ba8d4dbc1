#pragma once
#include <metrolux/export.h>

#include <functional>
#include <string>

namespace metrolux {

enum class LogLevel { Info, Warning };

/// Receives what the library has to say beside its errors: warnings of scenes, parameters without effect,
/// files that could not be written on the way. Default: nobody does. It may be called by any thread that
/// calls the library, one at a time.
METROLUX_API void setLog(std::function<void(LogLevel, const std::string&)> receiver);

}  // namespace metrolux
