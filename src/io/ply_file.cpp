#include "io/ply_file.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

namespace metrolux::core::ply {

namespace {

namespace fs = std::filesystem;

struct TypeName {
    std::string_view name;
    Type type;
};
constexpr TypeName kTypeNames[] = {
    {"char", Type::Int8},       {"int8", Type::Int8},       {"uchar", Type::UInt8},
    {"uint8", Type::UInt8},     {"short", Type::Int16},     {"int16", Type::Int16},
    {"ushort", Type::UInt16},   {"uint16", Type::UInt16},   {"int", Type::Int32},
    {"int32", Type::Int32},     {"uint", Type::UInt32},     {"uint32", Type::UInt32},
    {"float", Type::Float32},   {"float32", Type::Float32}, {"double", Type::Float64},
    {"float64", Type::Float64},
};

std::vector<std::string_view> split(std::string_view line) {
    std::vector<std::string_view> tokens;
    for (;;) {
        const size_t begin = line.find_first_not_of(" \t\r");
        if (begin == std::string_view::npos) return tokens;
        line.remove_prefix(begin);
        tokens.push_back(line.substr(0, line.find_first_of(" \t\r")));
        line.remove_prefix(tokens.back().size());
    }
}

class HeaderParser {
  public:
    HeaderParser(const fs::path& path, std::string_view file) : path_(path), file_(file) {}

    Header parse() {
        if (nextLine() != std::vector<std::string_view>{"ply"})
            fail("not a PLY file (its first line is not \"ply\")");
        bool hasFormat = false;
        for (;;) {
            const auto tokens = nextLine();
            if (tokens.empty() || tokens[0] == "comment" || tokens[0] == "obj_info") continue;
            if (tokens[0] == "end_header") break;
            if (tokens[0] == "format" && tokens.size() == 3) {
                header_.format = formatOf(tokens[1]);
                hasFormat = true;
            } else if (tokens[0] == "element" && tokens.size() == 3) {
                header_.elements.push_back({std::string(tokens[1]), countOf(tokens[2]), {}});
            } else if (tokens[0] == "property" && !header_.elements.empty()) {
                addProperty(tokens);
            } else {
                fail(fmt::format("header: \"{}\" is not understood", tokens[0]));
            }
        }
        if (!hasFormat) fail("header: no format");
        header_.size = position_;
        return std::move(header_);
    }

  private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error("{}:{}: {}", path_.string(), line_, what);
    }

    std::vector<std::string_view> nextLine() {
        ++line_;
        const size_t end = file_.find('\n', position_);
        if (end == std::string_view::npos) fail("truncated: the header has no end_header");
        const std::string_view line = file_.substr(position_, end - position_);
        position_ = end + 1;
        return split(line);
    }

    Format formatOf(std::string_view name) const {
        if (name == "ascii") return Format::Ascii;
        if (name == "binary_little_endian") return Format::LittleEndian;
        if (name == "binary_big_endian") return Format::BigEndian;
        fail(fmt::format("format \"{}\", expected ascii, binary_little_endian or binary_big_endian", name));
    }

    uint64_t countOf(std::string_view token) const {
        uint64_t count = 0;
        const auto [end, code] = std::from_chars(token.data(), token.data() + token.size(), count);
        if (code != std::errc() || end != token.data() + token.size())
            fail(fmt::format("\"{}\" is not a number of elements", token));
        return count;
    }

    Type typeOf(std::string_view name) const {
        for (const TypeName& t : kTypeNames)
            if (t.name == name) return t.type;
        fail(fmt::format("unknown type \"{}\"", name));
    }

    void addProperty(const std::vector<std::string_view>& tokens) {
        auto& properties = header_.elements.back().properties;
        if (tokens.size() == 3)
            properties.push_back({std::string(tokens[2]), typeOf(tokens[1]), std::nullopt});
        else if (tokens.size() == 5 && tokens[1] == "list" && integerRange(typeOf(tokens[2])) > 0)
            properties.push_back({std::string(tokens[4]), typeOf(tokens[3]), typeOf(tokens[2])});
        else
            fail(
                "a property is \"property <type> <name>\" or \"property list <integer type> <type> <name>\"");
    }

    const fs::path& path_;
    std::string_view file_;
    size_t position_ = 0, line_ = 0;
    Header header_;
};

/// Fewest bytes that an element's row takes.
uint64_t minimumRow(const Element& element, Format format) {
    uint64_t bytes = 0;
    for (const Property& p : element.properties)
        bytes += format == Format::Ascii ? 2 : sizeOf(p.countType.value_or(p.type));
    return bytes;
}

}  // namespace

size_t sizeOf(Type type) {
    switch (type) {
        case Type::Int8:
        case Type::UInt8:
            return 1;
        case Type::Int16:
        case Type::UInt16:
            return 2;
        case Type::Int32:
        case Type::UInt32:
        case Type::Float32:
            return 4;
        case Type::Float64:
            return 8;
    }
    return 8;
}

double integerRange(Type type) {
    switch (type) {
        case Type::Int8:
            return 127;
        case Type::UInt8:
            return 255;
        case Type::Int16:
            return 32767;
        case Type::UInt16:
            return 65535;
        case Type::Int32:
            return 2147483647.0;
        case Type::UInt32:
            return 4294967295.0;
        default:
            return 0;
    }
}

Header parseHeader(const fs::path& path, std::string_view file) { return HeaderParser(path, file).parse(); }

void Values::enter(const Element& element) {
    element_ = &element;
    const uint64_t row = minimumRow(element, format_);
    // The last value of an ascii file may have no space behind it.
    if (row > 0 && element.count > (data_.size() + 1) / row)
        throw Error("{}: truncated: {} elements \"{}\" are declared, the {} bytes left hold at most {}",
                    path_.string(), element.count, element.name, data_.size(), (data_.size() + 1) / row);
}

uint64_t Values::listLength(const Property& property) {
    const double count = next(*property.countType);
    const size_t each = format_ == Format::Ascii ? 2 : sizeOf(property.type);
    if (!(count >= 0) || count > static_cast<double>((data_.size() + 1) / each) || count != std::floor(count))
        throw Error("{}: a list of {} values in element \"{}\", more than the file holds", path_.string(),
                    count, element_->name);
    return static_cast<uint64_t>(count);
}

double Values::nextAscii() {
    const size_t begin = data_.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) throwTruncated();
    data_.remove_prefix(begin);
    if (data_[0] == '+') data_.remove_prefix(1);
    double value = 0;
    const auto [end, code] = std::from_chars(data_.data(), data_.data() + data_.size(), value);
    const auto length = static_cast<size_t>(end - data_.data());
    const bool ends = length == data_.size() || std::strchr(" \t\r\n", data_[length]) != nullptr;
    if ((code != std::errc() && code != std::errc::result_out_of_range) || !ends)
        throw Error("{}: \"{}\" in element \"{}\" is not a number", path_.string(),
                    data_.substr(0, std::min<size_t>(data_.find_first_of(" \t\r\n"), 40)), element_->name);
    data_.remove_prefix(length);
    return value;
}

template <class T>
double Values::take() {
    if (data_.size() < sizeof(T)) throwTruncated();
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), data_.data(), sizeof(T));
    data_.remove_prefix(sizeof(T));
    if ((format_ == Format::BigEndian) == (std::endian::native == std::endian::little))
        std::reverse(bytes.begin(), bytes.end());
    return static_cast<double>(std::bit_cast<T>(bytes));
}

double Values::nextBinary(Type type) {
    switch (type) {
        case Type::Int8:
            return take<int8_t>();
        case Type::UInt8:
            return take<uint8_t>();
        case Type::Int16:
            return take<int16_t>();
        case Type::UInt16:
            return take<uint16_t>();
        case Type::Int32:
            return take<int32_t>();
        case Type::UInt32:
            return take<uint32_t>();
        case Type::Float32:
            return take<float>();
        case Type::Float64:
            return take<double>();
    }
    return 0;
}

void Values::throwTruncated() const {
    throw Error("{}: truncated within element \"{}\"", path_.string(), element_->name);
}

}  // namespace metrolux::core::ply
