#include "study/build_description.h"

// On its own, because the definition comes from CMake and changes with each commit.
namespace metrolux::core::study {

const char* const kBuildRevision = METROLUX_REVISION;

}  // namespace metrolux::core::study
