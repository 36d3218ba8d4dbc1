#include "app/all_sensors.h"
#include "app/commands.h"
#include "app/interrupt.h"
#include "app/live_options.h"
#include "app/progress_json.h"
#include "app/render_options.h"
#include "base/error.h"
#include "image/atomic_file.h"
#include "render/progress.h"
#include "view/watched.h"

#include <metrolux/log.h>

#include <spdlog/spdlog.h>

namespace metrolux::core::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRenderExamples = R"(Examples:
  metrolux render scene.xml                            # a minute, to an EXR named after the scene
  metrolux render scene.xml -o a.exr -o a.png --time 1h
  metrolux render scene.xml --error 0.02               # until the estimated relative error is 2 %
  metrolux render scene.xml -i path --passes 64 --seed 7
  metrolux render scene.xml --resolution 320x180 --crop 100,50,64,64 -D material=glass
  metrolux render scene.xml -o a.exr --aov albedo,normal,depth,variance --stats a.json
  metrolux render scene.xml -o a.exr -o a.png --denoise   # a.png without noise, a.exr with both
  metrolux render scene.xml -o a.exr --passes 6400 --slices 64 --only-slices 0-7 --checkpoint part0
  mpirun -n 16 metrolux render scene.xml -o a.exr --passes 6400 --slices 64
  metrolux render scene.xml --serve                    # prints the address of a page that shows it
  metrolux render scene.xml -o a.exr --time 8h --checkpoint a.checkpoint   # `metrolux resume` goes on from it

Ctrl-C ends the pass in progress, writes the image and exits with status 3; a second Ctrl-C exits at once.
The same scene, options and number of passes give the same image on any number of threads.)";

}  // namespace

void reportNonFinite(const std::string& statistics) {
    const nlohmann::json all = nlohmann::json::parse(statistics);
    if (const auto beyond = all["beyond_single_precision"].get<uint64_t>(); beyond > 0)
        spdlog::warn(
            "{} values of the image are too large or too small for single precision, which loses digits "
            "of them or all",
            beyond);
    const nlohmann::json& counts = all["non_finite"];
    for (const auto& [technique, count] : counts.items())
        if (count.get<uint64_t>() > 0)
            spdlog::warn("{} contributions of the technique '{}' were not finite and were left out",
                         count.get<uint64_t>(), technique);
}

namespace {

/// What a file has of the denoised image.
std::string denoisedNote(const fs::path& file, const std::string& statistics) {
    const std::string denoiser = nlohmann::json::parse(statistics).value("denoiser", "");
    if (denoiser.empty()) return "";
    return OutputSet::isPicture(file) ? fmt::format(", denoised by {}", denoiser)
                                      : fmt::format(", with the layer {} by {}", kDenoisedLayer, denoiser);
}

}  // namespace

int conclude(const metrolux::Outcome& outcome, const std::string& statistics, const RenderArguments& a) {
    bool lost = !outcome.failures.empty();
    for (const std::string& failure : outcome.failures) spdlog::error("{}", failure);
    for (const fs::path& file : outcome.rescued) spdlog::error("the image is in {} instead", file.string());
    if (!a.stats.empty()) {
        try {
            writeFile(a.stats, statistics + "\n");
        } catch (const Error& error) {
            spdlog::error("{}", error.what());
            lost = true;
        }
    }
    if (!outcome.checkpointFailure.empty()) {
        spdlog::error("the last checkpoint was not written: {}", outcome.checkpointFailure);
        lost = true;
    }
    if (lost) return kOutputLost;
    if (outcome.passes == 0) {
        spdlog::warn("interrupted before the first pass: nothing was written");
        return kInterrupted;
    }
    for (const std::string& file : a.outputs)
        spdlog::info("wrote {}{}", file, denoises(a) ? denoisedNote(file, statistics) : "");
    if (outcome.reason == metrolux::StopReason::Full)
        spdlog::warn("ended after {} passes, the most that a rendering can have", outcome.passes);
    if (outcome.reason != metrolux::StopReason::Interrupted) return kDone;
    const fs::path& checkpoint = a.files.checkpoint;
    if (checkpoint.empty())
        spdlog::info("interrupted after {} passes; with --checkpoint FILE `metrolux resume FILE` could go on",
                     outcome.passes);
    else
        spdlog::info("interrupted after {} passes; `metrolux resume {}` goes on", outcome.passes,
                     checkpoint.string());
    return kInterrupted;
}

namespace {

/// Shows what happens. While it lives, what the library has to say comes below the line of progress.
class Reporter {
  public:
    explicit Reporter(const RenderArguments& a)
        : arguments_(a),
          line_(ProgressReporter::modeFor(stderr, a.quiet || a.progress != "text")),
          speaksJson_(a.progress == "json" && a.rank == 0) {
        metrolux::setLog([this](metrolux::LogLevel level, const std::string& message) {
            say(level == metrolux::LogLevel::Warning, message);
        });
    }
    ~Reporter() { metrolux::setLog({}); }
    Reporter(const Reporter&) = delete;
    Reporter& operator=(const Reporter&) = delete;

    void begin(const metrolux::Scene& scene, const std::string& integrator, int threads) {
        const metrolux::Crop window = scene.window();
        spdlog::info("{}: {}x{} pixels, integrator {}, {} threads", arguments_.scene, window.width,
                     window.height, integrator, threads);
        if (speaksJson_) json_.begin(arguments_.scene, window, integrator, threads);
    }
    void pass(const metrolux::Progress& p) {
        line_.update({p.passes, p.seconds, p.relativeError, p.secondsRemaining}, p.raysPerSecond,
                     arguments_.verbose ? p.note : "");
        if (speaksJson_) json_.pass(p);
    }
    void page(const std::string& url) {
        tellPage(url);
        if (speaksJson_) json_.page(url);
    }
    void warn(const std::string& message) { say(true, message); }
    /// Reports what became of the files; the exit status.
    int end(const metrolux::Outcome& outcome, const std::string& statistics) {
        line_.finish();
        reportNonFinite(statistics);
        const int status = conclude(outcome, statistics, arguments_);
        if (speaksJson_) json_.end(outcome, arguments_.outputs, status);
        return status;
    }

  private:
    void say(bool warning, const std::string& message) {
        line_.finish();
        spdlog::log(warning ? spdlog::level::warn : spdlog::level::info, "{}", message);
        if (speaksJson_) json_.log(warning ? "warning" : "info", message);
    }

    const RenderArguments& arguments_;
    ProgressReporter line_;
    JsonProgress json_;
    bool speaksJson_;
};

/// The scene, and what of the options depends on it.
metrolux::Scene loaded(RenderArguments& a) {
    metrolux::Scene scene = metrolux::Scene::load(a.scene, loadOptions(a));
    if (a.rank == 0) checkDistinct(namedOutputs(a), Internals::of(scene).files);
    completeAlgorithm(a, *Internals::of(scene).scene);
    return scene;
}

/// For those who watch; null if nobody is to.
std::unique_ptr<view::LiveView> makeLiveView(const RenderArguments& a, Reporter& reporter) {
    if (!a.live.isWanted()) return nullptr;
    auto live = std::make_unique<view::LiveView>(liveOptions(a.live), boardInfo(a));
    if (!live->url().empty()) reporter.page(live->url());
    return live;
}

int renderAlone(RenderArguments& a, std::optional<Checkpoint> before) {
    if (a.quiet) spdlog::set_level(spdlog::level::warn);
    Reporter reporter(a);
    prepareRender(a);
    catchInterrupts();
    const std::unique_ptr<view::LiveView> live = makeLiveView(a, reporter);
    const metrolux::Scene scene = loaded(a);
    metrolux::Session session(scene, a.session);
    if (before) Internals::restore(session, *std::move(before), a.otherBuild);
    reporter.begin(scene, session.integrator(), session.threads());
    const metrolux::Hooks hooks{[&](const metrolux::Progress& p) {
                                    reporter.pass(p);
                                    if (live)
                                        for (const std::string& text : live->takeWarnings())
                                            reporter.warn(text);
                                },
                                interruptRequested};
    const metrolux::Outcome outcome =
        live ? view::renderWatched(session, a.limits, hooks, a.files, live->board())
             : session.render(a.limits, hooks, a.files);
    return reporter.end(outcome, session.statistics());
}

/// One of the processes of a team.
int renderTogether(Team& team, RenderArguments& a, std::optional<Checkpoint> before) {
    if (a.quiet) spdlog::set_level(a.rank > 0 ? spdlog::level::err : spdlog::level::warn);
    Reporter reporter(a);
    prepareRender(a);
    catchInterrupts();
    const metrolux::Scene scene = loaded(a);
    Workers workers(a.session.threads);
    return workers.execute([&] {
        SessionOptions options = api::coreOptions(scene, a.session);
        options.rank = a.rank;
        RenderSession session(Internals::of(scene).scene, options);
        if (before) session.restore(*std::move(before), a.otherBuild);
        reporter.begin(scene, session.options().integrator, workers.threads());
        const metrolux::Hooks hooks{[&](const metrolux::Progress& p) { reporter.pass(p); },
                                    interruptRequested};
        const SessionResult result =
            session.runTogether(team, api::runOptions(a.limits, a.files), api::runHooks(hooks));
        if (a.rank > 0) return int{kDone};  // rank 0 reports
        return reporter.end(api::outcomeOf(result), result.statistics.dump(2));
    });
}

}  // namespace

int render(RenderArguments& a, std::optional<Checkpoint> before) {
    const std::unique_ptr<Team> team = makeTeam();
    if (!team) {
        try {
            return renderAlone(a, std::move(before));
        } catch (const Error& error) {
            if (a.progress == "json") JsonProgress().error(error.what(), kUserError);
            throw;
        }
    }
    // An error of one process ends all: the others would wait for it.
    try {
        if (a.live.isWanted())
            throw Error("--serve and --tev are for a rendering of one process, found {}", team->size());
        if (a.slices == 0 || !a.onlySlices.empty())
            throw Error(
                "{} processes share the slices of a rendering: give --slices S, without --only-slices",
                team->size());
        a.rank = team->rank();
        if (team->rank() > 0) a.quiet = true;
        return renderTogether(*team, a, std::move(before));
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
    app->footer(kRenderExamples);
    auto arguments = std::make_shared<RenderArguments>();
    addRenderOptions(*app, *arguments);
    return [arguments] {
        if (wantsAllSensors(*arguments)) return renderAllSensors(*arguments);
        warnOfReplaced(arguments->files.checkpoint);
        return render(*arguments, std::nullopt);
    };
}

}  // namespace metrolux::core::app
