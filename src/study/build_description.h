#pragma once

namespace metrolux::core::study {

/// The commit that the build was configured at ("unknown" outside of git).
extern const char* const kBuildRevision;

}  // namespace metrolux::core::study
