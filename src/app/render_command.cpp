#include "app/commands.h"
#include "app/interrupt.h"
#include "app/render_options.h"
#include "base/error.h"
#include "image/atomic_file.h"
#include "io/scene_loader.h"
#include "render/session.h"
#include "render/threads.h"

#include <spdlog/spdlog.h>

namespace metrolux::core::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExamples = R"(Examples:
  metrolux render scene.xml                            # a minute, to scene.exr
  metrolux render scene.xml -o a.exr -o a.png --time 1h
  metrolux render scene.xml --error 0.02               # until the estimated relative error is 2 %
  metrolux render scene.xml -i path --passes 64 --seed 7
  metrolux render scene.xml --resolution 320x180 --crop 100,50,64,64 -D material=glass
  metrolux render scene.xml -o a.exr --aov albedo,normal,depth,variance --stats a.json
  metrolux render scene.xml -o a.exr --passes 6400 --streams 64 --only-streams 0-7 --checkpoint part0
  mpirun -n 16 metrolux render scene.xml -o a.exr --passes 6400 --streams 64
  metrolux render scene.xml -o a.exr --time 8h --checkpoint a.checkpoint   # `metrolux resume` goes on from it

Ctrl-C ends the pass in progress, writes the image and exits with status 3; a second Ctrl-C exits at once.
The same scene, options and number of passes give the same image on any number of threads.)";

}  // namespace

void reportNonFinite(const nlohmann::json& counts) {
    for (const auto& [technique, count] : counts.items())
        if (count.get<uint64_t>() > 0)
            spdlog::warn("{} contributions of the technique '{}' were not finite and were left out",
                         count.get<uint64_t>(), technique);
}

int conclude(const SessionResult& result, const RenderArguments& a) {
    bool lost = !result.written.failures.empty();
    for (const std::string& failure : result.written.failures) spdlog::error("{}", failure);
    for (const fs::path& file : result.written.rescued)
        spdlog::error("the image is in {} instead", file.string());
    if (!a.stats.empty()) {
        try {
            writeFile(a.stats, result.statistics.dump(2) + "\n");
        } catch (const Error& error) {
            spdlog::error("{}", error.what());
            lost = true;
        }
    }
    if (!result.checkpointFailure.empty()) {
        spdlog::error("the last checkpoint was not written: {}", result.checkpointFailure);
        lost = true;
    }
    if (lost) return kOutputLost;
    if (result.passes == 0) {
        spdlog::warn("interrupted before the first pass: nothing was written");
        return kInterrupted;
    }
    for (const std::string& file : a.outputs) spdlog::info("wrote {}", file);
    if (result.reason != StopReason::Interrupted) return kDone;
    const fs::path& checkpoint = a.session.checkpoint.file;
    if (checkpoint.empty())
        spdlog::info("interrupted after {} passes; with --checkpoint FILE `metrolux resume FILE` could go on",
                     result.passes);
    else
        spdlog::info("interrupted after {} passes; `metrolux resume {}` goes on", result.passes,
                     checkpoint.string());
    return kInterrupted;
}

namespace {

/// The scene's part of a rendering's identity.
nlohmann::json sceneIdentity(const RenderArguments& a, const std::vector<fs::path>& files) {
    nlohmann::json identity = {{"files", fingerprints(files)},
                               {"name", fs::path(a.scene).filename().string()},
                               {"define", a.defines},
                               {"filter", a.filter},
                               {"lenient", a.lenient}};
    if (!a.sensor.empty()) identity["sensor"] = a.sensor;
    return identity;
}

int renderOn(Team* team, RenderArguments& a, std::optional<Checkpoint> before) {
    if (a.quiet) spdlog::set_level(a.session.rank > 0 ? spdlog::level::err : spdlog::level::warn);
    prepareRender(a);
    catchInterrupts();
    ThreadLimit limit(a.threads);
    return limit.execute([&] {
        std::vector<fs::path> files;
        SceneParts parts = loadSceneParts(a.scene, a, &files);
        if (a.session.rank == 0) checkDistinct(namedOutputs(a), files);
        for (const std::string& warning : parts.warnings) spdlog::warn("{}", warning);
        const Scene scene(std::move(parts));
        PathLimits& limits = a.session.integratorOptions.limits;
        limits = scene.parts().limits;
        if (a.maxDepth) limits.maxDepth = *a.maxDepth;
        if (!a.session.checkpoint.file.empty() || team) a.session.checkpoint.scene = sceneIdentity(a, files);
        const std::string integrator = integratorName(a.session.integrator, scene);
        if (a.session.integrator == "scene") warnOfUnusedOptions(a, integrator);
        RenderSession session(scene, a.session);
        if (before) session.restore(*std::move(before));
        const FilmWindow& window = scene.camera().window();
        spdlog::info("{}: {}x{} pixels, integrator {}, {} threads", a.scene, window.width, window.height,
                     integrator, limit.threads());
        ProgressReporter progress(ProgressReporter::modeFor(stderr, a.quiet));
        const SessionResult result = team ? session.runTogether(*team, progress, interruptRequested)
                                          : session.run(progress, interruptRequested);
        if (a.session.rank > 0) return int{kDone};  // rank 0 reports
        reportNonFinite(result.statistics["non_finite"]);
        return conclude(result, a);
    });
}

}  // namespace

int render(RenderArguments& a, std::optional<Checkpoint> before) {
    const std::unique_ptr<Team> team = makeTeam();
    if (!team) return renderOn(nullptr, a, std::move(before));
    // An error of one process ends all: the others would wait for it.
    try {
        if (a.streams == 0 || !a.onlyStreams.empty())
            throw Error(
                "{} processes share the streams of a rendering: give --streams S, without --only-streams",
                team->size());
        a.session.rank = team->rank();
        if (team->rank() > 0) a.quiet = true;
        return renderOn(team.get(), a, std::move(before));
    } catch (const std::exception& problem) {
        fmt::print(stderr, "metrolux: rank {}: {}\n", team->rank(), problem.what());
        const int status = dynamic_cast<const Error*>(&problem) ? kUserError : kInternalError;
        team->abort(status);
        return status;
    }
}

namespace {

/// Somebody may have meant to go on.
void warnOfReplaced(const fs::path& checkpoint) {
    if (!checkpoint.empty() && fs::exists(checkpoint))
        spdlog::warn("{} exists and will be replaced ({} keeps it); `metrolux resume {}` would go on from it",
                     checkpoint.string(), previousCheckpoint(checkpoint).string(), checkpoint.string());
}

}  // namespace

Run addRenderCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("render", "Render a scene to image files");
    app->footer(kExamples);
    auto arguments = std::make_shared<RenderArguments>();
    addRenderOptions(*app, *arguments);
    return [arguments] {
        warnOfReplaced(arguments->session.checkpoint.file);
        return render(*arguments, std::nullopt);
    };
}

}  // namespace metrolux::core::app
