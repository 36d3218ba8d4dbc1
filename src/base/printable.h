#pragma once
#include <string>
#include <string_view>

namespace metrolux::core {

/// Bytes of the UTF-8 character that `text` begins with (RFC 3629, table of section 4); 0 if that is none.
size_t utf8Length(std::string_view text);

/// Text of files, names and users as a terminal or a log may show it: on one line, as nothing but text.
/// Control characters, line separators, characters that change the direction of text, and bytes that are no
/// UTF-8 become escapes: \n, \x1b, \u202e.
std::string printable(std::string_view text);
/// The same, but lines stay lines: for a message whose parts are printable already.
std::string printableLines(std::string_view text);
/// Text for JSON and for the attributes of images: bytes that are no UTF-8 become escapes, \xff.
std::string validUtf8(std::string_view text);

}  // namespace metrolux::core
