#include "io/mitsuba/source.h"

#include "io/lfs_pointer.h"

#include <algorithm>
#include <fstream>

namespace metrolux::core::mitsuba {
namespace {

/// Far above any scene description (meshes and images are files of their own).
constexpr uintmax_t kMaxFileBytes = uintmax_t(256) << 20;

std::string readText(const std::filesystem::path& file) {
    std::error_code code;
    const auto status = std::filesystem::status(file, code);
    if (!std::filesystem::exists(status)) throw Error("{}: the file does not exist", file.string());
    if (std::filesystem::is_directory(status))
        throw Error("{}: found a folder, expected a scene file (.xml)", file.string());
    if (!std::filesystem::is_regular_file(status))
        throw Error("{}: not a regular file, expected a scene file (.xml)", file.string());
    refuseLfsPointer(file);
    const uintmax_t size = std::filesystem::file_size(file, code);
    if (code) throw Error("{}: cannot be read: {}", file.string(), code.message());
    if (size > kMaxFileBytes)
        throw Error("{}: the file has {} MiB, expected a scene file of at most {} MiB", file.string(),
                    size >> 20, kMaxFileBytes >> 20);
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw Error("{}: cannot be opened for reading", file.string());
    std::string text(size, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(size));
    if (stream.gcount() != static_cast<std::streamsize>(size))
        throw Error("{}: read only {} of {} bytes", file.string(), stream.gcount(), size);
    return text;
}

/// Offset of the first byte that is not valid UTF-8, or zero; npos without any.
size_t firstInvalidUtf8(const std::string& text) {
    for (size_t i = 0; i < text.size();) {
        const size_t length = text[i] == '\0' ? 0 : utf8Length(std::string_view(text).substr(i));
        if (length == 0) return i;
        i += length;
    }
    return std::string::npos;
}

bool declaresLatin1(const std::string& text) {
    std::string head = text.substr(0, std::min<size_t>(text.find("?>"), 200));
    std::transform(head.begin(), head.end(), head.begin(), [](unsigned char c) { return std::tolower(c); });
    return head.starts_with("<?xml") &&
           (head.find("iso-8859-1") != std::string::npos || head.find("latin1") != std::string::npos);
}

std::string latin1ToUtf8(const std::string& text) {
    std::string result;
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (code < 0x80) {
            result += c;
        } else {
            result += static_cast<char>(0xc0 | (code >> 6));
            result += static_cast<char>(0x80 | (code & 0x3f));
        }
    }
    return result;
}

}  // namespace

Source::Source(const std::filesystem::path& file) : file_(file), text_(readText(file)) {
    if (text_.starts_with("\xff\xfe") || text_.starts_with("\xfe\xff"))
        throw Error("{}: found UTF-16 text, expected XML in UTF-8", file.string());
    if (declaresLatin1(text_)) text_ = latin1ToUtf8(text_);
    lineStarts_.push_back(0);
    for (size_t i = 0; i < text_.size(); ++i)
        if (text_[i] == '\n') lineStarts_.push_back(i + 1);
    if (text_.find_first_not_of(" \t\r\n") == std::string::npos)
        throw Error("{}: the file is empty, expected <scene version=\"...\">", file.string());
    if (const size_t invalid = firstInvalidUtf8(text_); invalid != std::string::npos)
        throw Error("{}: found the byte 0x{:02x}, expected XML in UTF-8",
                    at(static_cast<ptrdiff_t>(invalid)).str(), static_cast<unsigned char>(text_[invalid]));

    const pugi::xml_parse_result result =
        document_.load_buffer(text_.data(), text_.size(), pugi::parse_default, pugi::encoding_utf8);
    if (!result) throw Error("{}: not well-formed XML: {}", at(result.offset).str(), result.description());
    for (const pugi::xml_node node : document_.children())
        if (node.type() == pugi::node_element && node != document_.document_element())
            throw Error("{}: found a second root element <{}>, expected one", at(node).str(), node.name());
}

Location Source::at(ptrdiff_t offset) const {
    const auto line = std::upper_bound(lineStarts_.begin(), lineStarts_.end(),
                                       static_cast<size_t>(std::max<ptrdiff_t>(offset, 0)));
    return {file_.string(), static_cast<int>(line - lineStarts_.begin())};
}

}  // namespace metrolux::core::mitsuba
