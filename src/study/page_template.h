#pragma once
#include <string_view>

namespace metrolux::core::study {

/// web/viewer.html, put into a source by cmake/Viewer.cmake.
extern const std::string_view kPageTemplate;

}  // namespace metrolux::core::study
