#include "app/image_info.h"

#include "base/printable.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace metrolux::core::app {
namespace {

nlohmann::json toJson(const MetadataValue& value) {
    return std::visit(
        [](const auto& v) -> nlohmann::json {
            if constexpr (std::is_same_v<std::decay_t<decltype(v)>, std::string>)
                return validUtf8(v);
            else
                return v;
        },
        value);
}

std::string textOf(const MetadataValue& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return printable(*text);
    if (const auto* matrix = std::get_if<Matrix>(&value)) {
        std::string rows;
        for (size_t i = 0; i < 4; ++i)
            rows += fmt::format("{}[{:.6g}]", i ? " " : "",
                                fmt::join(matrix->begin() + 4 * i, matrix->begin() + 4 * (i + 1), " "));
        return rows;
    }
    return toJson(value).dump();
}

}  // namespace

void printImage(const ImageInfo& image) {
    fmt::print("image       {}, {}x{} pixels", printable(image.format), image.width, image.height);
    const ImagePlace& p = image.place;
    if (p.isCrop()) fmt::print(" at {},{} of {}x{}", p.x, p.y, p.fullWidth, p.fullHeight);
    fmt::print("\nchannels   ");
    for (const std::string& channel : image.channels) fmt::print(" {}", printable(channel));
    fmt::print("\n");
    for (const auto& [name, value] : image.metadata)
        fmt::print("{:<24} {}\n", printable(name), textOf(value));
}

void printImageJson(const ImageInfo& image) {
    nlohmann::json channels = nlohmann::json::array(), metadata = nlohmann::json::object();
    for (const std::string& channel : image.channels) channels.push_back(validUtf8(channel));
    for (const auto& [name, value] : image.metadata) metadata[validUtf8(name)] = toJson(value);
    nlohmann::json result{{"format", image.format},
                          {"width", image.width},
                          {"height", image.height},
                          {"channels", channels},
                          {"metadata", metadata}};
    if (const ImagePlace& p = image.place; p.isCrop())
        result["window"] = {
            {"x", p.x}, {"y", p.y}, {"full_width", p.fullWidth}, {"full_height", p.fullHeight}};
    fmt::print("{}\n", result.dump(2, ' ', true));
}

}  // namespace metrolux::core::app
