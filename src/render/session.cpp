#include "render/session.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/memory_budget.h"
#include "base/state_archive.h"
#include "geometry/intersector.h"
#include "image/atomic_file.h"
#include "integrators/iteration.h"

#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

namespace metrolux::core {
namespace {

nlohmann::json numberOrNull(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

/// The integrators of streams. What the scene is probed for is found once.
StreamedIntegrator::Make streamMaker(const Scene& scene, const SessionOptions& options,
                                     const IntegratorChoice& choice) {
    const IntegratorFactory make = choice.integrator->prepare(scene, options.common, choice.parameters);
    const uint32_t count = options.streams.count;
    return [make, seed = options.common.seed, count](uint32_t stream) {
        return make(streamSeed(seed, stream, count));
    };
}

SessionOptions withIntegrator(SessionOptions options, const std::string& name) {
    options.integrator = name;
    return options;
}

/// `limits.passes` as those of the chosen streams.
RenderLimits limitsOfChoice(RenderLimits limits, const StreamChoice& choice) {
    if (limits.passes > 0) limits.passes = passesOfChoice(choice, limits.passes);
    return limits;
}

}  // namespace

RenderSession::RenderSession(const Scene& scene, SessionOptions options)
    : RenderSession(scene, options,
                    chooseIntegrator(options.integrator, scene.parts().integrator, options.parameters)) {}

RenderSession::RenderSession(const Scene& scene, SessionOptions options, const IntegratorChoice& choice)
    : RenderSession(scene, withIntegrator(options, choice.name()), toJson(choice.parameters),
                    streamMaker(scene, options, choice)) {}

RenderSession::RenderSession(const Scene& scene, SessionOptions options,
                             std::unique_ptr<Integrator> integrator)
    : RenderSession(scene, std::move(options), nlohmann::json::object(),
                    [made = std::make_shared<std::unique_ptr<Integrator>>(std::move(integrator))](uint32_t) {
                        return std::move(*made);
                    }) {}

RenderSession::RenderSession(const Scene& scene, SessionOptions options, nlohmann::json parameters,
                             StreamedIntegrator::Make make)
    : scene_(scene),
      options_(std::move(options)),
      parameters_(std::move(parameters)),
      outputs_(options_.outputs, options_.display, options_.overwrite),
      film_(makeFilm(scene)),
      integrator_(std::move(make), options_.streams, options_.limits.passes) {
    if (!options_.checkpoint.file.empty() && options_.rank == 0) checkWritable(options_.checkpoint.file);
}

nlohmann::json RenderSession::identity() const {
    const CommonOptions& o = options_.common;
    const FilmWindow& w = scene_.camera().window();
    const nlohmann::json algorithm{{"integrator", options_.integrator},
                                   {"parameters", parameters_},
                                   {"seed", o.seed},
                                   {"max_depth", o.limits.maxDepth},
                                   {"roulette_depth", o.limits.rouletteDepth},
                                   {"hide_emitters", o.limits.hideEmitters},
                                   {"iterations_per_pass", PixelPartition(w, o).parts()}};
    return {{"version", options_.version},
            {"scene", options_.checkpoint.scene},
            {"window", {w.x, w.y, w.width, w.height}},
            {"image", {w.fullWidth, w.fullHeight}},
            {"algorithm", algorithm},
            {"streams", options_.streams.count}};
}

void RenderSession::restore(Checkpoint checkpoint) {
    const auto different = differences(identity(), nlohmann::json::parse(checkpoint.identity));
    if (!different.empty())
        throw Error("the checkpoint belongs to another rendering:\n  {}", fmt::join(different, "\n  "));
    secondsBefore_ = checkpoint.seconds;
    integrator_.restore(std::move(checkpoint.streams));
    if (options_.rank > 0) return;  // rank 0 brings what was rendered before
    StateReader reader(checkpoint.film);
    film_.loadState(reader);
    reader.checkEnd();
    raysBefore_ = checkpoint.rays;
}

void RenderSession::begin() {
    const double start = steadySeconds();
    if (options_.rank == 0) cameraLayers_ = renderAovs(scene_, options_.aovs);
    secondsForAovs_ = steadySeconds() - start;
    Intersector::resetStatistics();
    nextSave_ = secondsBefore_ + options_.saveEvery;
    nextCheckpoint_ = secondsBefore_ + options_.checkpoint.every;
    if (options_.rank > 0) return;
    if (!options_.checkpoint.file.empty()) removeLeftovers(options_.checkpoint.file);
    for (const std::filesystem::path& output : options_.outputs) removeLeftovers(output);
}

SessionResult RenderSession::run(ProgressReporter& progress, const std::function<bool()>& interrupted) {
    begin();
    PassReport last{film_.passes(), secondsBefore_, film_.relativeError(), -1};
    PassLoopHooks hooks;
    hooks.interrupted = interrupted;
    hooks.secondsBefore = secondsBefore_;
    hooks.afterPass = [&](const PassReport& report) {
        last = report;
        const RayStatistics traced = rays();
        progress.update(report,
                        static_cast<double>(traced.intersectRays + traced.shadowRays) / report.seconds,
                        integrator_.progressNote());
        saveWhatIsDue(here(report), progress);
    };
    SessionResult result;
    result.reason =
        renderPasses(integrator_, film_, limitsOfChoice(options_.limits, options_.streams), hooks);
    progress.finish();
    conclude(here(last), result, progress);
    return result;
}

RenderSession::Snapshot RenderSession::here(const PassReport& report) const {
    return {film_, report, rays(), [this] { return integrator_.states(); }};
}

void RenderSession::conclude(const Snapshot& end, SessionResult& result, ProgressReporter& progress) {
    result.passes = end.film.passes();
    result.statistics = statistics(end, result.reason);
    if (result.passes == 0) return;
    saveCheckpoint(end, progress);
    result.checkpointFailure = checkpointFailure_;
    result.written = outputs_.writeOrRescue(frame(end));
}

void RenderSession::saveWhatIsDue(const Snapshot& now, ProgressReporter& progress) {
    if (now.report.seconds >= nextCheckpoint_) saveCheckpoint(now, progress);
    if (!(options_.saveEvery > 0) || now.report.seconds < nextSave_) return;
    nextSave_ = now.report.seconds + options_.saveEvery;
    for (const std::string& failure : outputs_.write(frame(now))) {
        progress.finish();
        spdlog::warn("intermediate image: {}", failure);
    }
}

void RenderSession::saveCheckpoint(const Snapshot& now, ProgressReporter& progress) {
    const std::filesystem::path& file = options_.checkpoint.file;
    if (file.empty()) return;
    nextCheckpoint_ = now.report.seconds + options_.checkpoint.every;
    try {
        writeCheckpoint(file, checkpoint(now));
        checkpointFailure_.clear();
    } catch (const std::exception& problem) {
        checkpointFailure_ = problem.what();
        progress.finish();
        spdlog::warn("checkpoint: {}", checkpointFailure_);
    }
}

Checkpoint RenderSession::checkpoint(const Snapshot& now) const {
    Checkpoint c;
    c.version = options_.version;
    c.command = options_.checkpoint.command;
    c.folder = options_.checkpoint.folder;
    for (const std::filesystem::path& output : options_.outputs) c.outputs.push_back(output.string());
    c.limits = options_.limits;
    c.identity = identity().dump();
    c.seconds = now.report.seconds;
    c.rays = now.rays;
    c.window = now.film.window();
    StateWriter writer;
    now.film.saveState(writer);
    c.film = writer.take();
    c.streams = now.streams();
    return c;
}

RayStatistics RenderSession::rays() const {
    RayStatistics rays = Intersector::statistics();
    rays.intersectRays += raysBefore_.intersectRays;
    rays.shadowRays += raysBefore_.shadowRays;
    rays.secondsInEmbree += raysBefore_.secondsInEmbree;
    return rays;
}

RenderedFrame RenderSession::frame(const Snapshot& now) const {
    RenderedFrame frame;
    const PassReport& report = now.report;
    frame.image = {now.film.width(), now.film.height(), 3, now.film.image()};
    frame.layers = cameraLayers_;
    for (Aov aov : options_.aovs)
        if (aov == Aov::Variance) frame.layers.push_back(varianceLayer(now.film));
    const FilmWindow& w = now.film.window();
    frame.metadata = {
        {"Software", "Metrolux " + options_.version},
        {"metrolux:scene", scene_.parts().source},
        {"metrolux:integrator", options_.integrator},
        {"metrolux:passes", static_cast<int>(report.passes)},
        {"metrolux:seconds", report.seconds},
        {"metrolux:seed", std::to_string(options_.common.seed)},
        {"metrolux:window",
         fmt::format("{}x{} at {},{} of {}x{}", w.width, w.height, w.x, w.y, w.fullWidth, w.fullHeight)},
    };
    if (std::isfinite(report.relativeError))
        frame.metadata.emplace_back("metrolux:relativeError", report.relativeError);
    return frame;
}

nlohmann::json nonFiniteCounts(const Film& film) {
    nlohmann::json counts = nlohmann::json::object();
    const TechniqueCounts all = film.nonFinite();
    for (size_t i = 0; i < all.size(); ++i) counts[techniqueName(static_cast<Technique>(i))] = all[i];
    return counts;
}

nlohmann::json RenderSession::statistics(const Snapshot& now, StopReason reason) const {
    const PassReport& report = now.report;
    const RayStatistics& traced = now.rays;
    const int threads = tbb::this_task_arena::max_concurrency();
    const double seconds = report.seconds;
    const FilmWindow& w = film_.window();
    return {
        {"version", options_.version},
        {"scene", scene_.parts().source},
        {"integrator", options_.integrator},
        {"parameters", parameters_},
        {"seed", options_.common.seed},
        {"threads", threads},
        {"window", {{"x", w.x}, {"y", w.y}, {"width", w.width}, {"height", w.height}}},
        {"image", {{"width", w.fullWidth}, {"height", w.fullHeight}}},
        {"stop_reason", stopReasonName(reason)},
        {"passes", report.passes},
        {"seconds", seconds},
        {"seconds_for_aovs", secondsForAovs_},
        {"relative_error", numberOrNull(report.passes > 0 ? report.relativeError : kInfinity)},
        {"rays",
         {{"intersect", traced.intersectRays},
          {"shadow", traced.shadowRays},
          {"per_second",
           seconds > 0 ? static_cast<double>(traced.intersectRays + traced.shadowRays) / seconds : 0.0},
          {"share_of_time", seconds > 0 ? traced.secondsInEmbree / (seconds * threads) : 0.0}}},
        {"peak_memory_bytes", peakMemoryBytes()},
        {"non_finite", nonFiniteCounts(now.film)},
        {"integrator_statistics", integrator_.statistics()},
    };
}

}  // namespace metrolux::core
