#pragma once

namespace metrolux::core::study {

/// What the compiler was told, and the commit that the build was configured at ("unknown" outside of git).
extern const char* const kBuildFlags;
extern const char* const kBuildRevision;

}  // namespace metrolux::core::study
