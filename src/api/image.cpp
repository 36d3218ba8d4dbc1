#include "api/internals.h"
#include "image/compare.h"

#include <metrolux/image.h>
#include <metrolux/version.h>

namespace metrolux {
namespace {

core::ImageData dataOf(const ImageView& view) {
    if (view.size() > 0 && !view.data) throw core::Error("found an image without pixels");
    return {view.width, view.height, view.channels, {view.data, view.data + view.size()}};
}

Image imageOf(core::ImageData data) {
    return {std::move(data.pixels), data.height, data.width, data.channels};
}

/// Three channels; gray has three that are equal.
core::ImageData colorOf(const ImageView& image) {
    if (image.channels == 3) return dataOf(image);
    if (image.channels != 1)
        throw core::Error("found an image of {} channels, expected 3 or 1", image.channels);
    const core::ImageData gray = dataOf(image);
    core::ImageData color{gray.width, gray.height, 3, {}};
    color.pixels.reserve(3 * gray.pixels.size());
    for (const float value : gray.pixels) color.pixels.insert(color.pixels.end(), 3, value);
    return color;
}

bool isRaw(const Display& display) { return display.curve == "none"; }

}  // namespace

core::OutputSet::Display core::api::displayOf(const Display& display) {
    const std::optional<ToneCurve> curve = toneCurveFromName(display.curve);
    if (!curve) throw Error("unknown tone curve '{}', expected srgb or filmic", display.curve);
    return {static_cast<float>(display.exposure), *curve};
}

Image readImage(const std::filesystem::path& file) { return imageOf(core::readImage(file, false)); }

void writeImage(const std::filesystem::path& file, const ImageView& image, const Display& display) {
    const core::Metadata metadata{{"Software", std::string("Metrolux ") + version()}};
    if (isRaw(display) && file.extension() == ".png")
        return core::writePngRaw(file, colorOf(image), metadata);
    const core::OutputSet output({file}, core::api::displayOf(display), true);
    for (const std::string& failure : output.write({colorOf(image), {}, metadata}))
        throw core::Error(failure);
}

std::string encodePng(const ImageView& image, const Display& display) {
    if (isRaw(display)) return core::encodePngRaw(colorOf(image));
    const core::OutputSet::Display d = core::api::displayOf(display);
    return core::encodePng(colorOf(image), d.exposure, d.curve);
}

std::vector<std::uint8_t> displayImage(const ImageView& image, const Display& display) {
    const core::OutputSet::Display d = core::api::displayOf(display);
    return core::displayBytes(colorOf(image), d.exposure, d.curve);
}

Difference compare(const ImageView& a, const ImageView& b, double epsilon) {
    const core::ImageDifference d = core::compareImages(dataOf(a), dataOf(b), epsilon);
    return {d.mse,       d.relMse, d.trimmedRelMse, d.smape,  d.bias,
            d.biasError, d.meanA,  d.meanB,         d.pixels, d.nonFinite};
}

Image heatMap(const ImageView& a, const ImageView& b, double epsilon) {
    return imageOf(core::errorHeatMap(dataOf(a), dataOf(b), epsilon));
}

}  // namespace metrolux
