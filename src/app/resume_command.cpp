#include "app/commands.h"
#include "app/option_parsing.h"
#include "app/render_options.h"
#include "app/validators.h"
#include "base/error.h"
#include "render/progress.h"

#include <metrolux/version.h>

#include <spdlog/spdlog.h>

namespace metrolux::core::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kResumeExamples = R"(Examples:
  metrolux resume a.checkpoint                         # to the limits of the render command, and its files
  metrolux resume a.checkpoint --passes 200            # further than it was to go
  metrolux resume a.checkpoint --time 20h -o b.exr     # 20 hours with those before the checkpoint
  metrolux resume a.checkpoint.1                       # from the checkpoint before the last

The image is that of a rendering that was never stopped, bit for bit. The scene, its files and the program have to be
the same; files are named as they were, relative to the folder of the render command. Limits given here
replace all limits of the render command and count what was rendered before. Checkpoints go on in the same file.)";

struct ResumeArguments {
    std::string file;
    RenderArguments overrides;  ///< limits, outputs, threads
};

/// The options of the render command that the checkpoint comes from.
void parseCommand(const std::vector<std::string>& command, RenderArguments& a) {
    CLI::App app;
    app.set_help_flag();
    addRenderOptions(app, a);
    if (command.size() < 2) throw Error("the checkpoint names no render command");
    try {
        app.parse(std::vector<std::string>(command.rbegin(), command.rend() - 2));
    } catch (const CLI::ParseError& problem) {
        throw Error("the checkpoint's render command cannot be read: {}", problem.what());
    }
}

void enterFolder(const std::string& folder) {
    std::error_code code;
    fs::current_path(folder, code);
    if (code)
        spdlog::warn("the folder {} of the render command is not here: files are looked for in {}", folder,
                     fs::current_path().string());
}

std::vector<std::string> absolutePaths(std::vector<std::string> files) {
    for (std::string& file : files) file = fs::absolute(file).string();
    return files;
}

/// The checkpoint's options with what is to replace them.
RenderArguments argumentsOf(const Checkpoint& checkpoint, const ResumeArguments& a) {
    RenderArguments result;
    parseCommand(checkpoint.command, result);
    result.files.command = checkpoint.command;
    result.live = {};
    result.outputs = a.overrides.outputs.empty() ? checkpoint.outputs : a.overrides.outputs;
    result.session.threads = a.overrides.session.threads;
    result.quiet = a.overrides.quiet;
    result.verbose = a.overrides.verbose;
    result.otherBuild = a.overrides.otherBuild;
    result.progress = a.overrides.progress;
    metrolux::Limits limits = a.overrides.limits;
    if (!a.overrides.time.empty()) limits.seconds = parseDuration(a.overrides.time);
    if (!a.overrides.error.empty()) limits.relativeError = parseRelativeError(a.overrides.error);
    result.time.clear();
    result.error.clear();
    const RenderLimits& before = checkpoint.limits;
    if (!limits.any()) limits = {before.seconds, before.passes, before.relativeError};
    result.limits = limits;
    if (!a.overrides.checkpointEvery.empty()) result.checkpointEvery = a.overrides.checkpointEvery;
    return result;
}

int resume(ResumeArguments& a) {
    Checkpoint checkpoint = readCheckpoint(a.file, metrolux::version());
    a.overrides.outputs = absolutePaths(std::move(a.overrides.outputs));
    enterFolder(checkpoint.folder);
    RenderArguments arguments = argumentsOf(checkpoint, a);
    if (!arguments.quiet)
        spdlog::info("going on with {} after {}", arguments.scene, durationText(checkpoint.seconds));
    return render(arguments, std::move(checkpoint));
}

}  // namespace

Run addResumeCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("resume", "Go on with a rendering from a checkpoint");
    app->footer(kResumeExamples);
    auto arguments = std::make_shared<ResumeArguments>();
    app->add_option("checkpoint", arguments->file, "File of `metrolux render --checkpoint FILE`")->required();
    RenderArguments& overrides = arguments->overrides;
    app->add_option("-o,--output", overrides.outputs, "Images to write in place of the render command's")
        ->option_text("FILE")
        ->allow_extra_args(false);
    app->add_option("--checkpoint-every", overrides.checkpointEvery, "Time between checkpoints")
        ->option_text("TIME");
    app->add_option("--threads", overrides.session.threads, "Number of threads (default: one for each core)")
        ->option_text("T")
        ->check(wholeNumber(1, 4096));
    app->add_flag("--quiet", overrides.quiet, "Show errors and warnings only");
    addProgressOptions(*app, overrides, "");
    app->add_flag(
        "--other-build", overrides.otherBuild,
        "Go on although another build of this version, or another kind of machine, has written\nthe "
        "checkpoint: the image is right, its last bits could differ");
    addLimitOptions(*app, overrides, "those of the render command");
    return [arguments] { return resume(*arguments); };
}

}  // namespace metrolux::core::app
