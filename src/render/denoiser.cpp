#include "render/denoiser.h"

#include "base/error.h"
#include "base/state_archive.h"
#include "image/denoise.h"
#include "render/aov.h"
#include "render/open_image_denoise.h"

#include <cmath>

namespace metrolux::core {
namespace {

/// Features of a file that somebody made may be anything.
std::vector<float> finite(std::vector<float> values) {
    for (float& x : values)
        if (!std::isfinite(x)) x = 0;
    return values;
}

}  // namespace

DenoisingState DenoisingState::parse(const std::string& bytes, size_t pixels) {
    DenoisingState state{HalfSums(pixels), {}};
    loadState(bytes, state);
    DenoisingFeatures& f = state.features;
    checkState(
        f.albedo.size() == 3 * pixels && f.normal.size() == 3 * pixels && f.inverseDistance.size() == pixels,
        "features of all pixels");
    f = {finite(std::move(f.albedo)), finite(std::move(f.normal)), finite(std::move(f.inverseDistance))};
    return state;
}

DenoisedImage denoise(const Film& film, const HalfSums& halves, const DenoisingFeatures& features) {
    constexpr const char* kOwn = "own filter";
    const std::vector<float> color = film.image();
    DenoisedImage result{{kDenoisedLayer, {"R", "G", "B"}, {}}, kOwn, {}};
    try {
        if (const auto library = OpenImageDenoise::load()) {
            result.layer.pixels =
                library->denoise({film.width(), film.height(), color, features.albedo, features.normal});
            result.denoiser = library->name();
            return result;
        }
    } catch (const Error& problem) {
        // The image is not lost for it.
        result.warnings.push_back(fmt::format("{}: our own filter has denoised the image", problem.what()));
    }
    if (halves.firstPasses() == 0 || halves.firstPasses() >= film.passes()) {
        result.warnings.emplace_back(
            "--denoise: the noise of one pass is not known, expected two at least: the image is as it was "
            "rendered");
        result.layer.pixels = color;
        return result;
    }
    const auto [first, second] = halves.means(film);
    const std::vector<float> variance = film.variance();
    result.layer.pixels =
        denoise(NoisyImage{film.width(), film.height(), color, first, second, variance, halves.firstPasses(),
                           film.passes(), features.albedo, features.normal, features.inverseDistance});
    return result;
}

void checkDenoiser() { OpenImageDenoise::load(); }

}  // namespace metrolux::core
