#include "render/session.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/memory_budget.h"
#include "base/printable.h"
#include "base/state_archive.h"
#include "geometry/intersector.h"
#include "image/atomic_file.h"
#include "integrators/iteration.h"
#include "render/build_id.h"

#include <tbb/task_arena.h>

namespace metrolux::core {
namespace {

nlohmann::json numberOrNull(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

/// Of points in the coordinates of the file; the matrix is for those around an origin of the scene's own.
Matrix fromFile(Matrix m, const Vec3d& origin) {
    for (size_t c = 0; c < 4; ++c) {
        double shift = 0;
        for (size_t i = 0; i < 3; ++i) shift += origin[static_cast<int>(i)] * double(m[4 * i + c]);
        m[12 + c] = static_cast<float>(double(m[12 + c]) - shift);
    }
    return m;
}

/// The integrators of slices. What the scene is probed for is found once.
SlicedIntegrator::Make sliceMaker(const Scene& scene, const SessionOptions& options,
                                  const IntegratorChoice& choice) {
    const IntegratorFactory make = choice.integrator->prepare(scene, options.common, choice.parameters);
    const uint32_t count = options.slices.count;
    return [make, seed = options.common.seed, count](uint32_t slice) {
        return make(sliceSeed(seed, slice, count));
    };
}

SessionOptions withIntegrator(SessionOptions options, const std::string& name) {
    options.integrator = name;
    return options;
}

double raysPerSecond(const RayStatistics& rays, double seconds) {
    return seconds > 0 ? static_cast<double>(rays.all()) / seconds : 0.0;
}

/// `limits.passes` as those of the chosen slices.
RenderLimits limitsOfChoice(RenderLimits limits, const SliceChoice& choice) {
    if (limits.passes > 0) limits.passes = passesOfChoice(choice, limits.passes);
    return limits;
}

}  // namespace

RenderSession::RenderSession(const std::shared_ptr<const Scene>& scene, const SessionOptions& options)
    : RenderSession(scene, options,
                    chooseIntegrator(options.integrator, scene->parts().integrator, options.parameters)) {}

RenderSession::RenderSession(const std::shared_ptr<const Scene>& scene, const SessionOptions& options,
                             const IntegratorChoice& choice)
    : RenderSession(scene, withIntegrator(options, choice.name()), toJson(choice.parameters),
                    sliceMaker(*scene, options, choice)) {}

RenderSession::RenderSession(std::shared_ptr<const Scene> scene, SessionOptions options,
                             std::unique_ptr<Integrator> integrator)
    : RenderSession(std::move(scene), std::move(options), nlohmann::json::object(),
                    [made = std::make_shared<std::unique_ptr<Integrator>>(std::move(integrator))](uint32_t) {
                        return std::move(*made);
                    }) {}

RenderSession::RenderSession(std::shared_ptr<const Scene> scene, SessionOptions options,
                             nlohmann::json parameters, SlicedIntegrator::Make make)
    : scene_(std::move(scene)),
      options_(std::move(options)),
      parameters_(std::move(parameters)),
      film_(makeFilm(*scene_)),
      integrator_(std::move(make), options_.slices) {
    if (std::find(options_.aovs.begin(), options_.aovs.end(), Aov::Denoised) == options_.aovs.end()) return;
    checkDenoiser();
    halves_ = std::make_shared<HalfSums>(static_cast<size_t>(film_.pixelCount()));
    integrator_.keepHalves(halves_);
}

nlohmann::json RenderSession::algorithmIdentity() const {
    const CommonOptions& o = options_.common;
    return {{"integrator", options_.integrator},
            {"parameters", parameters_},
            {"seed", o.seed},
            {"max_depth", o.limits.maxDepth},
            {"roulette_depth", o.limits.rouletteDepth},
            {"hide_emitters", o.limits.hideEmitters},
            {"iterations_per_pass", PixelPartition(scene_->camera().window(), o).parts()}};
}

nlohmann::json RenderSession::identity() const {
    if (!sceneIdentity_) sceneIdentity_ = options_.scene ? options_.scene() : nlohmann::json();
    const FilmWindow& w = scene_->camera().window();
    nlohmann::json identity{{"version", options_.version},
                            {"scene", *sceneIdentity_},
                            {"window", {w.x, w.y, w.width, w.height}},
                            {"image", {w.fullWidth, w.fullHeight}},
                            {"algorithm", algorithmIdentity()},
                            {kSliceCountKey, options_.slices.count},
                            {kBuildKey, buildIdentity(scene_->intersector())}};
    if (const int exponent = scene_->emissionExponent(); exponent != 0)
        identity[kEmissionExponentKey] = exponent;
    if (denoises()) identity[kHalvesKey] = true;
    return identity;
}

void RenderSession::restore(Checkpoint checkpoint, bool otherBuild) {
    nlohmann::json own = identity(), saved = nlohmann::json::parse(checkpoint.identity);
    const auto builds = buildDifferences(own, saved), different = differences(own, saved);
    if (!different.empty())
        throw Error("the checkpoint belongs to another rendering:\n  {}", fmt::join(different, "\n  "));
    if (!builds.empty() && !otherBuild)
        throw Error(
            "the checkpoint was written by another build of this version:\n  {}\nThe passes to come could "
            "differ from its own in last bits, which an image that must be repeatable does not allow. "
            "`metrolux resume --other-build` goes on all the same",
            fmt::join(builds, "\n  "));
    secondsBefore_ = checkpoint.seconds;
    integrator_.restore(std::move(checkpoint.slices));
    if (options_.rank > 0) return;  // rank 0 brings what was rendered before
    StateReader reader(checkpoint.film);
    film_.loadState(reader);
    reader.checkEnd();
    if (denoises()) *halves_ = DenoisingState::parse(checkpoint.denoising, film_.sums().size()).halves;
    nonFiniteBefore_ = checkpoint.nonFinite;
    raysBefore_ = checkpoint.rays;
}

const CameraLayers& RenderSession::cameraLayers() {
    if (!cameraLayers_) {
        const double start = steadySeconds();
        cameraLayers_ = renderAovs(*scene_, options_.aovs);
        secondsForAovs_ = steadySeconds() - start;
    }
    return *cameraLayers_;
}

std::vector<ImageLayer> RenderSession::takeCameraLayers() {
    cameraLayers();
    std::vector<ImageLayer> result = std::move(cameraLayers_->layers);
    cameraLayers_.reset();
    return result;
}

const DenoisingFeatures& RenderSession::features() {
    if (features_.empty()) {
        const double start = steadySeconds();
        features_ = renderFeatures(*scene_);
        secondsForFeatures_ = steadySeconds() - start;
    }
    return features_;
}

RenderSession::Run RenderSession::begin(const RunOptions& options, const RunHooks& hooks) {
    const bool writes = options_.rank == 0;
    Run run{options,
            hooks,
            OutputSet(writes ? options.outputs : std::vector<std::filesystem::path>(), options.display,
                      options.overwrite),
            secondsBefore_ + options.saveEvery,
            secondsBefore_ + options.checkpoint.every,
            {},
            {}};
    if (writes) {
        for (const std::filesystem::path& output : options.outputs)
            run.locks.emplace_back(fmt::format("output '{}'", output.string()), output);
        if (const std::filesystem::path& file = options.checkpoint.file; !file.empty())
            run.locks.emplace_back(fmt::format("checkpoint '{}'", file.string()), file);
        if (!options.checkpoint.file.empty()) checkWritable(options.checkpoint.file);
        if (!options.outputs.empty()) cameraLayers();
        if (!options.checkpoint.file.empty()) removeLeftovers(options.checkpoint.file);
        for (const std::filesystem::path& output : options.outputs) removeLeftovers(output);
    }
    // Files of the scene are read again for it: now, before somebody changes them.
    if (!options.checkpoint.file.empty()) identity();
    integrator_.setTotalPasses(options.limits.passes);
    counterStart_ = Intersector::statistics();
    counting_ = true;
    return run;
}

/// The passes until `seconds` become those before.
void RenderSession::end(double seconds) {
    secondsBefore_ = seconds;
    raysBefore_ = rays();
    counting_ = false;
}

SessionResult RenderSession::run(const RunOptions& options, const RunHooks& hooks) {
    const RenderLimits limits = limitsOfChoice(options.limits, options_.slices);
    Run run = begin(options, hooks);
    PassReport last = report();
    PassLoopHooks loop;
    loop.interrupted = hooks.interrupted;
    loop.secondsBefore = secondsBefore_;
    loop.afterPass = [&](const PassReport& report) {
        last = report;
        if (hooks.afterPass)
            hooks.afterPass(report, core::raysPerSecond(rays(), report.seconds), integrator_.progressNote());
        saveWhatIsDue(run, here(report));
    };
    SessionResult result;
    result.reason = renderPasses(integrator_, film_, limits, loop);
    lastReason_ = result.reason;
    conclude(run, here(last), result);
    end(last.seconds);
    return result;
}

PassReport RenderSession::step() {
    const RunOptions none;
    const RunHooks nobody;
    begin(none, nobody);
    const double start = steadySeconds();
    integrator_.renderPass(film_, film_.passes());
    end(secondsBefore_ + steadySeconds() - start);
    lastReason_.reset();
    return report();
}

PassReport RenderSession::report() const {
    return {film_.passes(), secondsBefore_, film_.relativeError(), -1};
}

RenderSession::Snapshot RenderSession::here(const PassReport& report) const {
    if (halves_) halves_->close(film_);
    return {film_, halves_.get(), report, nonFinite(), rays(), [this] { return integrator_.states(); }};
}

double RenderSession::raysPerSecond() const { return core::raysPerSecond(rays(), secondsBefore_); }
nlohmann::json RenderSession::statistics() const { return statistics(here(report()), lastReason_); }
RenderedFrame RenderSession::frame() { return frame(here(report()), Denoising::Done); }
Checkpoint RenderSession::checkpoint(const RunOptions& options) {
    return checkpoint(options, here(report()));
}

void RenderSession::conclude(Run& run, const Snapshot& end, SessionResult& result) {
    result.passes = end.film.passes();
    if (result.passes > 0) {
        saveCheckpoint(run, end);
        result.checkpointFailure = run.checkpointFailure;
        if (!run.outputs.files().empty()) {
            const RenderedFrame image = frame(end, Denoising::Done);
            for (const std::string& warning : image.warnings) run.warn(warning);
            result.written = run.outputs.writeOrRescue(image);
        }
    }
    result.statistics = statistics(end, result.reason);
}

void RenderSession::saveWhatIsDue(Run& run, const Snapshot& now) {
    if (now.report.seconds >= run.nextCheckpoint) saveCheckpoint(run, now);
    if (!(run.options.saveEvery > 0) || now.report.seconds < run.nextSave || run.outputs.files().empty())
        return;
    run.nextSave = now.report.seconds + run.options.saveEvery;
    for (const std::string& failure : run.outputs.write(frame(now, Denoising::Skipped)))
        run.warn("intermediate image: " + failure);
}

void RenderSession::saveCheckpoint(Run& run, const Snapshot& now) {
    const std::filesystem::path& file = run.options.checkpoint.file;
    if (file.empty()) return;
    run.nextCheckpoint = now.report.seconds + run.options.checkpoint.every;
    try {
        writeCheckpoint(file, checkpoint(run.options, now));
        run.checkpointFailure.clear();
    } catch (const std::exception& problem) {
        run.checkpointFailure = problem.what();
        run.warn("checkpoint: " + run.checkpointFailure);
    }
}

Checkpoint RenderSession::checkpoint(const RunOptions& options, const Snapshot& now) {
    Checkpoint c;
    c.version = options_.version;
    c.command = options.checkpoint.command;
    c.folder = options.checkpoint.folder;
    for (const std::filesystem::path& output : options.outputs) c.outputs.push_back(output.string());
    c.limits = options.limits;
    c.identity = identity().dump();
    c.seconds = now.report.seconds;
    c.nonFinite = now.nonFinite;
    c.rays = now.rays;
    c.window = now.film.window();
    StateWriter writer;
    now.film.saveState(writer);
    c.film = writer.take();
    if (now.halves) {
        features();
        c.denoising = saveState(DenoisingState{*now.halves, features_});
    }
    c.slices = now.slices();
    return c;
}

TechniqueCounts RenderSession::nonFinite() const {
    TechniqueCounts counts = nonFiniteBefore_;
    counts += integrator_.nonFinite();
    return counts;
}

RayStatistics RenderSession::rays() const {
    RayStatistics rays = raysBefore_;
    if (!counting_) return rays;
    return rays += Intersector::statistics() - counterStart_;
}

DenoisedImage RenderSession::denoised() {
    const Snapshot now = here(report());
    return denoise(now.film, *now.halves, features());
}

RenderedFrame RenderSession::frame(const Snapshot& now, Denoising denoising) {
    RenderedFrame frame;
    const PassReport& report = now.report;
    frame.image = {now.film.width(), now.film.height(), 3, now.film.image(), placeOf(now.film.window())};
    frame.layers = cameraLayers().layers;
    for (Aov aov : options_.aovs)
        if (aov == Aov::Variance) frame.layers.push_back(varianceLayer(now.film));
    const FilmWindow& w = now.film.window();
    frame.metadata = {
        {"Software", "Metrolux " + options_.version},
        {"metrolux:scene", validUtf8(scene_->parts().source)},
        {"metrolux:integrator", options_.integrator},
        {"metrolux:passes", static_cast<int>(report.passes)},
        {"metrolux:seconds", report.seconds},
        {"metrolux:seed", std::to_string(options_.common.seed)},
        {"metrolux:window",
         fmt::format("{}x{} at {},{} of {}x{}", w.width, w.height, w.x, w.y, w.fullWidth, w.fullHeight)},
    };
    frame.metadata.emplace_back("metrolux:options", algorithmIdentity().dump());
    if (const auto matrices = scene_->camera().matrices()) {
        frame.metadata.emplace_back("worldToCamera",
                                    fromFile(matrices->worldToCamera, scene_->parts().origin));
        frame.metadata.emplace_back("worldToNDC", fromFile(matrices->worldToNdc, scene_->parts().origin));
    }
    const Metadata& ofLayers = cameraLayers().attributes;
    frame.metadata.insert(frame.metadata.end(), ofLayers.begin(), ofLayers.end());
    if (denoises() && denoising == Denoising::Done) {
        features();
        const double start = steadySeconds();
        DenoisedImage denoised = denoise(now.film, *now.halves, features());
        secondsForDenoising_ = steadySeconds() - start;
        denoiser_ = denoised.denoiser;
        frame.layers.push_back(std::move(denoised.layer));
        frame.warnings = std::move(denoised.warnings);
        frame.metadata.emplace_back("metrolux:denoiser", denoiser_);
    }
    if (std::isfinite(report.relativeError))
        frame.metadata.emplace_back("metrolux:relativeError", report.relativeError);
    return frame;
}

nlohmann::json toJson(const TechniqueCounts& counts) {
    nlohmann::json json = nlohmann::json::object();
    for (size_t i = 0; i < counts.size(); ++i) json[techniqueName(static_cast<Technique>(i))] = counts[i];
    return json;
}

nlohmann::json RenderSession::statistics(const Snapshot& now, std::optional<StopReason> reason) const {
    const PassReport& report = now.report;
    const RayStatistics& traced = now.rays;
    const int threads = tbb::this_task_arena::max_concurrency();
    const double seconds = report.seconds;
    const FilmWindow& w = film_.window();
    return {
        {"version", options_.version},
        {"scene", validUtf8(scene_->parts().source)},
        {"integrator", options_.integrator},
        {"parameters", parameters_},
        {"seed", options_.common.seed},
        {"threads", threads},
        {"window", {{"x", w.x}, {"y", w.y}, {"width", w.width}, {"height", w.height}}},
        {"image", {{"width", w.fullWidth}, {"height", w.fullHeight}}},
        {"stop_reason", reason ? nlohmann::json(stopReasonName(*reason)) : nlohmann::json()},
        {"passes", report.passes},
        {"seconds", seconds},
        {"seconds_for_aovs", secondsForAovs_},
        {"seconds_for_features", secondsForFeatures_},
        {"seconds_for_denoising", secondsForDenoising_},
        {"denoiser", denoiser_},
        {"relative_error", numberOrNull(report.passes > 0 ? report.relativeError : kInfinity)},
        {"rays",
         {{"intersect", traced.intersectRays},
          {"shadow", traced.shadowRays},
          {"per_second", core::raysPerSecond(traced, seconds)},
          {"share_of_time", seconds > 0 ? traced.secondsInEmbree / (seconds * threads) : 0.0}}},
        {"peak_memory_bytes", peakMemoryBytes()},
        {"non_finite", toJson(now.nonFinite)},
        {"emission_exponent", scene_->emissionExponent()},
        {"beyond_single_precision", now.film.beyondFloat()},
        {"integrator_statistics", integrator_.statistics()},
    };
}

}  // namespace metrolux::core
