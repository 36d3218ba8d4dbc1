#include "study/page.h"

#include "base/error.h"
#include "study/page_template.h"

#include <algorithm>
#include <bit>
#include <half.h>
#include <stdexcept>
#include <zlib.h>

namespace metrolux::core::study {
namespace {

constexpr std::string_view kDataMarker = "@METROLUX_STUDY@", kPixelsMarker = "@METROLUX_PIXELS@";
constexpr float kLargestHalf = 65504;

std::vector<float> rgbValues(const ImageData& image) {
    if (image.channels == 3) return image.pixels;
    std::vector<float> values;
    values.reserve(static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * 3);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const float* p = image.at(x, y);
            const bool gray = image.channels < 3;
            values.insert(values.end(), {p[0], gray ? p[0] : p[1], gray ? p[0] : p[2]});
        }
    return values;
}

/// The bits of the numbers, byte planes one after the other.
template <class Bits, class ToBits>
std::vector<unsigned char> bytePlanes(const std::vector<float>& values, ToBits&& toBits) {
    std::vector<unsigned char> bytes(values.size() * sizeof(Bits));
    for (size_t i = 0; i < values.size(); ++i) {
        const Bits bits = toBits(values[i]);
        for (size_t b = 0; b < sizeof(Bits); ++b)
            bytes[b * values.size() + i] = static_cast<unsigned char>(bits >> (8 * b));
    }
    return bytes;
}

std::vector<unsigned char> compressed(const std::vector<unsigned char>& bytes) {
    uLongf size = ::compressBound(static_cast<uLong>(bytes.size()));
    std::vector<unsigned char> result(size);
    const int status = ::compress2(result.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), 6);
    if (status != Z_OK) throw std::runtime_error(fmt::format("zlib failed with status {}", status));
    result.resize(size);
    return result;
}

std::string base64(const std::vector<unsigned char>& bytes) {
    static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const size_t present = std::min<size_t>(3, bytes.size() - i);
        uint32_t word = 0;
        for (size_t b = 0; b < 3; ++b) word = word << 8 | (b < present ? bytes[i + b] : 0u);
        for (size_t digit = 0; digit < 4; ++digit)
            text += digit <= present ? kDigits[word >> (18 - 6 * digit) & 63] : '=';
    }
    return text;
}

/// JSON that may stand in a <script>: no "</script>" and no "<!--" can occur in it.
std::string scriptSafe(const nlohmann::ordered_json& json) {
    std::string text;
    for (char c : json.dump()) {
        if (c == '<')
            text += "\\u003c";
        else
            text += c;
    }
    return text;
}

void replaceMarker(std::string& page, std::string_view marker, const std::string& text) {
    const size_t at = page.find(marker);
    if (at == std::string::npos)
        throw std::logic_error(fmt::format("the template of the page has no {}", marker));
    page.replace(at, marker.size(), text);
}

}  // namespace

std::vector<PageImage> pageImages(const SceneStudy& study, const Plan& plan) {
    std::vector<PageImage> images{{"reference", &study.reference.image}};
    for (size_t e = 0; e < study.contributions.size(); ++e) {
        const std::vector<Run>& runs = study.contributions[e].runs;
        const auto run =
            std::find_if(runs.begin(), runs.end(), [](const Run& r) { return !r.image.pixels.empty(); });
        if (run != runs.end()) images.push_back({plan.entrants[e].label, &run->image});
    }
    return images;
}

std::string encodePixels(const ImageData& image, bool half) {
    const std::vector<float> values = rgbValues(image);
    if (half)
        return base64(compressed(bytePlanes<uint16_t>(
            values, [](float v) { return ::half(std::clamp(v, -kLargestHalf, kLargestHalf)).bits(); })));
    return base64(
        compressed(bytePlanes<uint32_t>(values, [](float v) { return std::bit_cast<uint32_t>(v); })));
}

std::string studyPage(const nlohmann::ordered_json& study, const std::vector<PageImage>& images) {
    size_t numbers = 0;
    for (const PageImage& image : images)
        numbers += static_cast<size_t>(image.image->width) * static_cast<size_t>(image.image->height) * 3;
    const bool half = numbers * sizeof(float) > kLargestFloatPage;
    nlohmann::ordered_json pixels{{"precision", half ? "half" : "single"}};
    for (const PageImage& image : images)
        pixels["images"].push_back({{"name", image.name},
                                    {"width", image.image->width},
                                    {"height", image.image->height},
                                    {"pixels", encodePixels(*image.image, half)}});
    std::string page(kPageTemplate);
    // The later marker first: what is filled in may contain anything.
    replaceMarker(page, kPixelsMarker, scriptSafe(pixels));
    replaceMarker(page, kDataMarker, scriptSafe(study));
    return page;
}

}  // namespace metrolux::core::study
