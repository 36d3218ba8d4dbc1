#pragma once
/// An XML file in memory, and where its nodes stand.

#include "io/mitsuba/properties.h"

#include <pugixml.hpp>

#include <filesystem>

namespace metrolux::core::mitsuba {

class Source {
  public:
    /// Reads and parses a file. Throws Error that names the file (and the line) if it cannot be read, is too
    /// large, is not text in UTF-8 (or declared Latin-1), or is not well-formed XML with one root element.
    explicit Source(const std::filesystem::path& file);

    pugi::xml_node root() const { return document_.document_element(); }
    const std::filesystem::path& file() const { return file_; }
    size_t bytes() const { return text_.size(); }
    Location at(pugi::xml_node node) const { return at(node.offset_debug()); }

  private:
    Location at(ptrdiff_t offset) const;

    std::filesystem::path file_;
    std::string text_;
    std::vector<size_t> lineStarts_;
    pugi::xml_document document_;
};

}  // namespace metrolux::core::mitsuba
