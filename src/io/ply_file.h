#pragma once
/// The container format of PLY: header and a sequence of numbers. What they mean is mesh_ply.cpp's business.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace metrolux::core::ply {

enum class Type { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

size_t sizeOf(Type type);
/// Largest value of an integer type, 0 for floating point.
double integerRange(Type type);

enum class Format { Ascii, LittleEndian, BigEndian };

struct Property {
    std::string name;
    Type type = Type::Float32;
    std::optional<Type> countType;  // of a list
};

struct Element {
    std::string name;
    uint64_t count = 0;
    std::vector<Property> properties;

    int find(std::string_view property) const {
        for (size_t i = 0; i < properties.size(); ++i)
            if (properties[i].name == property && !properties[i].countType) return static_cast<int>(i);
        return -1;
    }
};

struct Header {
    Format format = Format::Ascii;
    std::vector<Element> elements;
    size_t size = 0;  // bytes, to the first one of the data
};

/// Throws Error with the line of the header.
Header parseHeader(const std::filesystem::path& path, std::string_view file);

/// Values of the data section one after another, in any of the formats. Throws Error when they end or are no
/// numbers.
class Values {
  public:
    Values(const std::filesystem::path& path, std::string_view data, Format format)
        : path_(path), data_(data), format_(format) {}

    /// Begins an element: checks its count against what is left of the file.
    void enter(const Element& element);
    double next(Type type) { return format_ == Format::Ascii ? nextAscii() : nextBinary(type); }
    /// Length of a list, checked against what is left.
    uint64_t listLength(const Property& property);

  private:
    double nextAscii();
    double nextBinary(Type type);
    template <class T>
    double take();
    [[noreturn]] void throwTruncated() const;

    const std::filesystem::path& path_;
    std::string_view data_;
    Format format_;
    const Element* element_ = nullptr;
};

}  // namespace metrolux::core::ply
