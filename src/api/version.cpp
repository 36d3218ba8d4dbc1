#include <metrolux/version.h>

namespace metrolux {

const char* version() noexcept { return METROLUX_VERSION; }

}  // namespace metrolux
