#include "app/commands.h"
#include "app/render_options.h"
#include "base/error.h"

#include <metrolux/log.h>

#include <spdlog/spdlog.h>

namespace metrolux::core::app {
namespace {

constexpr const char* kMergeExamples = R"(Examples:
  metrolux render scene.xml --passes 6400 --slices 64 --only-slices 0-31 --checkpoint part0     # on one machine
  metrolux render scene.xml --passes 6400 --slices 64 --only-slices 32-63 --checkpoint part1    # on another
  metrolux merge part0 part1 -o image.exr -o image.png

The image is that of one process which renders all slices, bit for bit. Parts weigh as many as they have passes.
Parts of another scene, other options or another version, damaged ones and parts that overlap are refused;
missing slices are warned of: the image is right without them, and noisier.)";

struct MergeArguments {
    std::vector<std::string> parts;
    RenderArguments render;  ///< outputs
};

int merge(MergeArguments& a) {
    RenderArguments& options = a.render;
    if (options.quiet) spdlog::set_level(spdlog::level::warn);
    if (options.outputs.empty()) throw Error("there is no image to write: name it with -o FILE");
    prepareOutputs(options);
    checkDistinct(namedOutputs(options), std::vector<std::filesystem::path>(a.parts.begin(), a.parts.end()));
    metrolux::setLog([](metrolux::LogLevel, const std::string& message) { spdlog::warn("{}", message); });
    const metrolux::Merged merged =
        metrolux::merge({a.parts.begin(), a.parts.end()}, options.files, options.session.layers);
    reportNonFinite(merged.statistics);
    return conclude(merged.outcome, merged.statistics, options);
}

}  // namespace

Run addMergeCommand(CLI::App& parent) {
    CLI::App* app =
        parent.add_subcommand("merge", "Join the parts of a rendering that was divided into slices");
    app->footer(kMergeExamples);
    auto arguments = std::make_shared<MergeArguments>();
    app->add_option("parts", arguments->parts, "Checkpoints of `metrolux render --only-slices`")
        ->required()
        ->option_text("PART...");
    addOutputOptions(*app, arguments->render);
    return [arguments] { return merge(*arguments); };
}

}  // namespace metrolux::core::app
