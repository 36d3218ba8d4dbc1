#pragma once
#include <span>
#include <string_view>

namespace metrolux::core::view {

/// A file of the page: what lies in web/view, put into the program by cmake/EmbedFiles.cmake.
struct PageFile {
    std::string_view name, content;
};
extern const std::span<const PageFile> kPageFiles;

}  // namespace metrolux::core::view
