#include "study/build_description.h"

// On its own, because the definitions come from CMake and change with each commit.
namespace metrolux::core::study {

const char* const kBuildFlags = METROLUX_FLAGS;
const char* const kBuildRevision = METROLUX_REVISION;

}  // namespace metrolux::core::study
