#include "app/all_sensors.h"
#include "app/commands.h"
#include "app/interrupt.h"
#include "app/live_options.h"
#include "app/option_parsing.h"
#include "base/error.h"
#include "view/explorer.h"

#include <metrolux/log.h>

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <spawn.h>
#include <unistd.h>

namespace metrolux::core::app {
namespace {

constexpr const char* kViewExamples = R"(Examples:
  metrolux view scene.xml                              # prints the address of a page, and opens it on a desktop
  metrolux view scene.xml -i path --resolution 640x480 --port 8420
  metrolux view scene.xml --passes 64 -o a.exr         # stays after 64 passes, with what was rendered
  metrolux view scene.xml --serve-address 0.0.0.0      # for other machines, with a token in the address

On the page the camera is moved, the image cropped, the integrator changed and another one shown beside it; saving
writes the image and a checkpoint. Without a limit it renders until it is stopped. Ctrl-C ends it as it ends `render`:
the image is written.)";

/// The words of a `render` that gives the same image: without those of this command alone.
std::vector<std::string> renderWords(const std::vector<std::string>& words) {
    std::vector<std::string> result;
    for (size_t i = 0; i < words.size(); ++i) {
        const std::string& word = words[i];
        const std::string name = word.substr(0, word.find('='));
        if (i == 1) {
            result.emplace_back("render");
        } else if (name == "--port" || name == "--serve-address" || name == "--tev") {
            if (word == name) ++i;
        } else if (word != "--no-open") {
            result.push_back(word);
        }
    }
    return result;
}

/// Where there is a desktop, its browser shows the page.
void openBrowser(const std::string& url) {
    if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
    std::string program = "xdg-open", address = url;
    char* const words[] = {program.data(), address.data(), nullptr};
    posix_spawn_file_actions_t quietly;
    ::posix_spawn_file_actions_init(&quietly);
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        ::posix_spawn_file_actions_addopen(&quietly, descriptor, "/dev/null", 2 /* O_RDWR */, 0);
    pid_t child = 0;
    ::posix_spawnp(&child, words[0], &quietly, nullptr, words, environ);
    ::posix_spawn_file_actions_destroy(&quietly);
}

int view(RenderArguments& render) {
    if (render.quiet) spdlog::set_level(spdlog::level::warn);
    if (wantsAllSensors(render)) throw Error("--sensor all: one is shown at a time, name it");
    render.files.command = renderWords(commandWords());
    prepareRender(render);
    catchInterrupts();
    view::BoardInfo info = boardInfo(render);
    info.explores = true;
    info.layers = {"albedo", "normal", "depth", "alpha"};
    view::LiveView live(liveOptions(render.live), info);
    tellPage(live.url());
    if (!render.live.staysClosed) openBrowser(live.url());
    metrolux::setLog([&](metrolux::LogLevel level, const std::string& message) {
        const bool warning = level == metrolux::LogLevel::Warning;
        spdlog::log(warning ? spdlog::level::warn : spdlog::level::info, "{}", message);
        live.board().tell(message);
    });
    const metrolux::Scene scene = metrolux::Scene::load(render.scene, loadOptions(render));
    checkDistinct(namedOutputs(render), Internals::of(scene).files);
    render.session.integrator = completeAlgorithm(render, *Internals::of(scene).scene).name();
    view::Explorer explorer(scene,
                            {render.session, render.limits, render.files,
                             [&] {
                                 for (const std::string& text : live.takeWarnings()) spdlog::warn("{}", text);
                                 return interruptRequested();
                             }},
                            live.board());
    const view::Explorer::Result result = explorer.run();
    metrolux::setLog({});
    if (!result.statistics.empty()) reportNonFinite(result.statistics);
    return conclude(result.outcome, result.statistics, render);
}

}  // namespace

Run addViewCommand(CLI::App& parent) {
    CLI::App* app =
        parent.add_subcommand("view", "Render a scene on a page in the browser, and walk through it");
    app->footer(kViewExamples);
    auto arguments = std::make_shared<RenderArguments>();
    RenderArguments& render = *arguments;
    app->add_option("scene", render.scene,
                    "Mitsuba scene (XML of version 3.x, 2.x, 0.6 or 0.5), glTF, or pbrt")
        ->required();
    addSceneOptions(*app, render);
    addOutputOptions(*app, render);
    addPortOptions(*app, render.live);
    addLimitOptions(*app, render, "somebody stops it");
    addCheckpointOptions(*app, render);
    addAlgorithmOptions(*app, render);
    addMachineOptions(*app, render);
    return [arguments] { return view(*arguments); };
}

}  // namespace metrolux::core::app
