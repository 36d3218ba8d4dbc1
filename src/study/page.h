#pragma once
/// The web page of a study: one file with everything in it, made from the template of web/.

#include "study/study.h"

#include <string>
#include <string_view>

namespace metrolux::core::study {

/// An image of the page.
struct PageImage {
    std::string name;        ///< label of the entrant, or "reference"
    const ImageData* image;  ///< 3 channels, or 1 that stands for all
};
/// The reference and, for each entrant, the image of its first run that has one.
std::vector<PageImage> pageImages(const SceneStudy& study, const Plan& plan);

inline constexpr size_t kLargestFloatPage = size_t{64} << 20;  ///< bytes of all pixels in single precision

/// The page. Pixels are kept in single precision, as in the EXR files, while all of them together need no
/// more than kLargestFloatPage bytes, else in half precision (11 bits; values above 65504 become that); the
/// page says which.
std::string studyPage(const nlohmann::ordered_json& study, const std::vector<PageImage>& images);

/// Pixels row by row, RGB, each number little-endian, the first bytes of all numbers before the second ones
/// (which compresses better), compressed (zlib) and in Base64.
std::string encodePixels(const ImageData& image, bool half);

}  // namespace metrolux::core::study
