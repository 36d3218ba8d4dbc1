#include "base/printable.h"

#include <fmt/format.h>

#include <cstdint>

namespace metrolux::core {
namespace {

uint32_t codeOf(std::string_view character) {
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(character[i]); };
    if (character.size() == 1) return byte(0);
    uint32_t code = byte(0) & (0xffu >> (character.size() + 1));
    for (size_t i = 1; i < character.size(); ++i) code = code << 6 | (byte(i) & 0x3fu);
    return code;
}

/// C0 and C1 control characters, separators of lines and paragraphs, and what changes the direction of text.
bool isControl(uint32_t code) {
    return code < 0x20 || (code >= 0x7f && code <= 0x9f) || code == 0x200e || code == 0x200f ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069) || code == 0xfeff;
}

std::string escaped(uint32_t code) {
    switch (code) {
        case '\n':
            return "\\n";
        case '\r':
            return "\\r";
        case '\t':
            return "\\t";
        default:
            return code < 0x100 ? fmt::format("\\x{:02x}", code) : fmt::format("\\u{:04x}", code);
    }
}

/// `escapes(code)`: whether a character is replaced.
template <class Escapes>
std::string replaced(std::string_view text, Escapes&& escapes) {
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const size_t length = utf8Length(text);
        const std::string_view character = text.substr(0, length == 0 ? 1 : length);
        if (length == 0)
            result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
        else if (const uint32_t code = codeOf(character); escapes(code))
            result += escaped(code);
        else
            result += character;
        text.remove_prefix(character.size());
    }
    return result;
}

}  // namespace

size_t utf8Length(std::string_view text) {
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(i < text.size() ? text[i] : 0); };
    if (text.empty()) return 0;
    const unsigned char lead = byte(0);
    size_t length = 1;
    unsigned char lower = 0x80, upper = 0xbf;
    if (lead >= 0xc2 && lead <= 0xdf) {
        length = 2;
    } else if (lead >= 0xe0 && lead <= 0xef) {
        length = 3;
        if (lead == 0xe0) lower = 0xa0;
        if (lead == 0xed) upper = 0x9f;
    } else if (lead >= 0xf0 && lead <= 0xf4) {
        length = 4;
        if (lead == 0xf0) lower = 0x90;
        if (lead == 0xf4) upper = 0x8f;
    } else if (lead >= 0x80) {
        return 0;
    }
    for (size_t k = 1; k < length; ++k) {
        if (byte(k) < lower || byte(k) > upper) return 0;
        lower = 0x80, upper = 0xbf;
    }
    return length;
}

std::string printable(std::string_view text) { return replaced(text, isControl); }

std::string printableLines(std::string_view text) {
    return replaced(text, [](uint32_t code) { return code != '\n' && isControl(code); });
}

std::string validUtf8(std::string_view text) {
    return replaced(text, [](uint32_t) { return false; });
}

}  // namespace metrolux::core
