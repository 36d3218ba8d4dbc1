#include "app/commands.h"
#include "app/validators.h"
#include "base/error.h"
#include "image/atomic_file.h"
#include "image/compare.h"
#include "render/output.h"

#include <metrolux/version.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

namespace metrolux::core::app {
namespace {

constexpr const char* kCompareExamples = R"(Examples:
  metrolux compare image.exr reference.exr
  metrolux compare image.exr reference.exr --heatmap errors.png --json

MSE        mean squared difference
relMSE     mean of (a-b)^2 / (b^2 + epsilon)
trimmed    relMSE without the 0.1 % of the pixels where it is largest
sMAPE      mean of 2|a-b| / (|a|+|b|)
bias       (mean a - mean b) / mean b, with its standard error from tiles of 16x16 pixels
All means are over pixels and color channels. Integer formats such as PNG are decoded to linear values.)";

struct CompareArguments {
    std::string image, reference, heatMap, layer;
    bool overwrite = false;
    double epsilon = kRelMseEpsilon;
    bool json = false;
};

nlohmann::json numberOrNull(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

void printJson(const ImageDifference& d) {
    const nlohmann::json result{{"mse", numberOrNull(d.mse)},
                                {"rel_mse", numberOrNull(d.relMse)},
                                {"trimmed_rel_mse", numberOrNull(d.trimmedRelMse)},
                                {"smape", numberOrNull(d.smape)},
                                {"bias", numberOrNull(d.bias)},
                                {"bias_standard_error", numberOrNull(d.biasError)},
                                {"mean", numberOrNull(d.meanA)},
                                {"reference_mean", numberOrNull(d.meanB)},
                                {"pixels", d.pixels},
                                {"non_finite_pixels", d.nonFinite}};
    fmt::print("{}\n", result.dump(2));
}

void printTable(const ImageDifference& d) {
    fmt::print("MSE      {:.6g}\n", d.mse);
    fmt::print("relMSE   {:.6g}\n", d.relMse);
    fmt::print("trimmed  {:.6g}\n", d.trimmedRelMse);
    fmt::print("sMAPE    {:.6g}\n", d.smape);
    fmt::print("bias     {:+.4f} % +- {:.4f} %  (mean {:.6g}, reference {:.6g})\n", 100 * d.bias,
               100 * d.biasError, d.meanA, d.meanB);
    fmt::print("pixels   {} compared, {} not finite\n", d.pixels, d.nonFinite);
}

int compare(const CompareArguments& a) {
    if (!a.heatMap.empty()) {
        const OutputSet checked({a.heatMap}, {}, a.overwrite);
        checkDistinct(std::vector<NamedOutput>{{fmt::format("--heatmap '{}'", a.heatMap), a.heatMap}},
                      std::vector<std::filesystem::path>{a.image, a.reference});
    }
    ImageData image = readImage(a.image, false);
    if (!a.layer.empty()) {
        ImageLayer layer = readLayer(a.image, a.layer);
        image.channels = static_cast<int>(layer.channels.size());
        image.pixels = std::move(layer.pixels);
    }
    const ImageData reference = readImage(a.reference, false);
    const ImageDifference difference = compareImages(image, reference, a.epsilon);
    if (a.json)
        printJson(difference);
    else
        printTable(difference);
    if (a.heatMap.empty()) return kDone;
    const std::string map = encodePngRaw(errorHeatMap(image, reference, a.epsilon),
                                         {{"Software", std::string("Metrolux ") + metrolux::version()}});
    try {
        writeFile(a.heatMap, map);
    } catch (const Error& error) {
        spdlog::error("{}", error.what());
        return kOutputLost;
    }
    return kDone;
}

}  // namespace

Run addCompareCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("compare", "Measure how far an image is from a reference");
    app->footer(kCompareExamples);
    auto a = std::make_shared<CompareArguments>();
    app->add_option("image", a->image, "Image to judge")->required();
    app->add_option("reference", a->reference, "Image that is taken as right")->required();
    app->add_option(
           "--heatmap", a->heatMap,
           "PNG of the relative error of each pixel:\nblack 0.001, blue, violet, orange, yellow, white 1")
        ->option_text("FILE");
    app->add_option("--layer", a->layer,
                    "Layer of the image to judge in place of its colors, such as denoised")
        ->option_text("NAME");
    app->add_flag("--overwrite", a->overwrite,
                  "Replace an existing image that Metrolux has not written, too");
    app->add_option("--epsilon", a->epsilon,
                    "Of relMSE: keeps black pixels from counting without limit (default: 0.01)")
        ->option_text("X")
        ->check(realNumber(false));
    app->add_flag("--json", a->json, "Print JSON");
    return [a] { return compare(*a); };
}

}  // namespace metrolux::core::app
