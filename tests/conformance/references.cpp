#include "references.h"

#include "image/compare.h"
#include "paths.h"
#include "support/shared_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

namespace metrolux::core::test {

namespace fs = std::filesystem;

namespace {

const fs::path kFolders[] = {sharedPath("conformance/tests/scenes"),
                             sharedPath("conformance-media/tests/scenes")};
const fs::path kOutput = fs::path(METROLUX_BINARY_DIR) / "conformance";

// ITU-R BT.709 primaries and D65, as sRGB's definition rounds them.
constexpr double kXyzFromRgb[3][3] = {
    {0.412453, 0.357580, 0.180423}, {0.212671, 0.715160, 0.072169}, {0.019334, 0.119193, 0.950227}};
constexpr double kRgbFromXyz[3][3] = {
    {3.240479, -1.537150, -0.498535}, {-0.969256, 1.875991, 0.041556}, {0.055648, -0.204043, 1.057311}};

void multiply(const double (&matrix)[3][3], std::vector<float>& pixels) {
    for (size_t i = 0; i + 2 < pixels.size(); i += 3) {
        double out[3] = {};
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) out[r] += matrix[r][c] * pixels[i + c];
        for (int r = 0; r < 3; ++r) pixels[i + r] = static_cast<float>(out[r]);
    }
}

ImageData readXyz(const fs::path& file) {
    const ImageData read = readImage(file, true);
    ImageData image;
    image.width = read.width;
    image.height = read.height;
    image.channels = 3;
    for (int y = 0; y < read.height; ++y)
        for (int x = 0; x < read.width; ++x)
            for (int c = 0; c < 3; ++c) image.pixels.push_back(read.at(x, y)[read.channels >= 3 ? c : 0]);
    toXyz(image.pixels);
    return image;
}

std::string fileName(std::string scene, const std::string& suffix) {
    std::replace(scene.begin(), scene.end(), '/', '-');
    return scene + suffix;
}

}  // namespace

std::vector<ConformanceScene> conformanceScenes() {
    std::vector<ConformanceScene> scenes;
    std::vector<fs::directory_entry> entries;
    for (const fs::path& folder : kFolders)
        if (fs::is_directory(folder))
            entries.insert(entries.end(), fs::recursive_directory_iterator(folder), {});
    for (const fs::directory_entry& entry : entries) {
        if (entry.path().extension() != ".xml") continue;
        // <name>_<integrator>.xml
        const std::string stem = entry.path().stem().string();
        const std::string name = stem.substr(0, stem.rfind('_'));
        const fs::path folder = entry.path().parent_path(), refs = folder / "refs";
        ConformanceScene scene{folder.filename().string() + "/" + name, entry.path(),
                               refs / (name + "_ref_rgb.exr"), refs / (name + "_ref_rgb_var.exr")};
        if (fs::exists(scene.reference) && fs::exists(scene.variance)) scenes.push_back(std::move(scene));
    }
    std::sort(scenes.begin(), scenes.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
    return scenes;
}

Reference readReference(const ConformanceScene& scene) {
    // The variance images hold the variances of X, Y and Z, converted to RGB as if they were colors.
    return {readXyz(scene.reference), readXyz(scene.variance)};
}

void toXyz(std::vector<float>& rgb) { multiply(kXyzFromRgb, rgb); }

ZTest zTest(const std::vector<float>& imageXyz, const Reference& reference, int samples) {
    constexpr double kVarianceFloor = 1e-4, kSignificance = 0.01;
    const double pixels = double(imageXyz.size()) / 3;
    const double alpha = -std::expm1(std::log1p(-kSignificance) / pixels);
    ZTest result;
    result.pValues.resize(imageXyz.size());
    size_t above = 0;
    for (size_t i = 0; i < imageXyz.size(); ++i) {
        const double variance = std::max<double>(reference.variance.pixels[i], kVarianceFloor);
        const double z =
            std::abs(double(imageXyz[i]) - reference.image.pixels[i]) * std::sqrt(samples / variance);
        const double p = std::erfc(z * std::numbers::sqrt2 / 2);
        result.pValues[i] = static_cast<float>(p);
        above += p > alpha;
    }
    result.share = double(above) / double(imageXyz.size());
    return result;
}

void writeFailure(const std::string& name, std::vector<float> imageXyz, const Reference& reference,
                  const std::vector<float>& pValues) {
    fs::create_directories(kOutput);
    ImageData image = reference.image, expected = reference.image, p = reference.image;
    image.pixels = std::move(imageXyz);
    multiply(kRgbFromXyz, image.pixels);
    multiply(kRgbFromXyz, expected.pixels);
    p.pixels = pValues;
    writeExr(kOutput / fileName(name, "-image.exr"), image);
    writeExr(kOutput / fileName(name, "-reference.exr"), expected);
    writePng(kOutput / fileName(name, "-image.png"), image);
    writePng(kOutput / fileName(name, "-reference.png"), expected);
    writePngRaw(kOutput / fileName(name, "-error.png"), errorHeatMap(image, expected));
    writePngRaw(kOutput / fileName(name, "-p.png"), p);
}

void writeRow(const std::string& scene, const std::string& integrator, const std::string& result,
              double seconds) {
    fs::create_directories(kOutput);
    const std::string row = fmt::format("| {} | {} | {} | {:.1f} |", scene, integrator, result, seconds);
    fmt::print("{}\n", row);
    std::ofstream(kOutput / fileName(scene, "-" + integrator + ".row")) << row << "\n";
}

}  // namespace metrolux::core::test
