#pragma once
#include <metrolux/export.h>

namespace metrolux {

/// Of the library that runs, "1.2.3". A checkpoint can be resumed by the version that wrote it.
METROLUX_API const char* version() noexcept;

}  // namespace metrolux
