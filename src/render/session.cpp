#include "render/session.h"

#include "base/error.h"
#include "geometry/intersector.h"

#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <map>
#include <sys/resource.h>

namespace metrolux {
namespace {

uint64_t peakMemoryBytes() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    return uint64_t{1024} * static_cast<uint64_t>(usage.ru_maxrss);
}

uint64_t raysTraced() {
    const RayStatistics rays = Intersector::statistics();
    return rays.intersectRays + rays.shadowRays;
}

nlohmann::json numberOrNull(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

SessionOptions resolved(const Scene& scene, SessionOptions options) {
    if (options.integrator == "scene") options.integrator = integratorForScene(scene.parts().integrator);
    return options;
}

}  // namespace

std::string integratorForScene(const std::string& sceneType) {
    for (const auto& [name, description] : integratorList())
        if (name == sceneType) return name;
    static const std::map<std::string, std::string> kMitsubaTypes{
        {"path", "path"},         {"volpath", "path"},  {"volpathmis", "path"}, {"direct", "path"},
        {"ptracer", "light"},     {"bdpt", "bdpt"},     {"sppm", "sppm"},       {"ppm", "sppm"},
        {"photonmapper", "sppm"}, {"pssmlt", "pssmlt"}, {"mlt", "mcmc_vcm"},    {"vcm", "vcm"},
    };
    const auto found = kMitsubaTypes.find(sceneType);
    if (found == kMitsubaTypes.end())
        throw Error("the scene's integrator '{}' has no counterpart here; choose one with --integrator",
                    sceneType);
    return found->second;
}

RenderSession::RenderSession(const Scene& scene, SessionOptions options)
    : RenderSession(scene, resolved(scene, std::move(options)), nullptr) {
    integrator_ = makeIntegrator(options_.integrator, scene_, options_.integratorOptions);
}

RenderSession::RenderSession(const Scene& scene, SessionOptions options,
                             std::unique_ptr<Integrator> integrator)
    : scene_(scene),
      options_(std::move(options)),
      outputs_(options_.outputs, options_.display),
      film_(scene.camera().window(), ReconstructionFilter(scene.parts().filterKind, scene.parts().filter)),
      integrator_(std::move(integrator)) {}

SessionResult RenderSession::run(ProgressReporter& progress, const std::function<bool()>& interrupted) {
    const auto start = std::chrono::steady_clock::now();
    cameraLayers_ = renderAovs(scene_, options_.aovs);
    secondsForAovs_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    Intersector::resetStatistics();
    nextSave_ = options_.saveEvery;

    PassReport last;
    PassLoopHooks hooks;
    hooks.interrupted = interrupted;
    hooks.afterPass = [&](const PassReport& report) {
        last = report;
        progress.update(report, static_cast<double>(raysTraced()) / report.seconds,
                        integrator_->progressNote());
        saveIntermediate(report, progress);
    };
    SessionResult result;
    result.reason = renderPasses(*integrator_, film_, options_.limits, hooks);
    progress.finish();
    result.passes = film_.passes();
    result.statistics = statistics(last, result.reason);
    if (result.passes > 0) result.written = outputs_.writeOrRescue(frame(last));
    return result;
}

void RenderSession::saveIntermediate(const PassReport& report, ProgressReporter& progress) {
    if (!(options_.saveEvery > 0) || report.seconds < nextSave_) return;
    nextSave_ = report.seconds + options_.saveEvery;
    for (const std::string& failure : outputs_.write(frame(report))) {
        progress.finish();
        spdlog::warn("intermediate image: {}", failure);
    }
}

RenderedFrame RenderSession::frame(const PassReport& report) const {
    RenderedFrame frame;
    frame.image = {film_.width(), film_.height(), 3, film_.image()};
    frame.layers = cameraLayers_;
    for (Aov aov : options_.aovs)
        if (aov == Aov::Variance) frame.layers.push_back(varianceLayer(film_));
    const FilmWindow& w = film_.window();
    frame.metadata = {
        {"Software", "Metrolux " + options_.version},
        {"metrolux:scene", scene_.parts().source},
        {"metrolux:integrator", options_.integrator},
        {"metrolux:passes", static_cast<int>(report.passes)},
        {"metrolux:seconds", report.seconds},
        {"metrolux:seed", std::to_string(options_.integratorOptions.seed)},
        {"metrolux:window",
         fmt::format("{}x{} at {},{} of {}x{}", w.width, w.height, w.x, w.y, w.fullWidth, w.fullHeight)},
    };
    if (std::isfinite(report.relativeError))
        frame.metadata.emplace_back("metrolux:relativeError", report.relativeError);
    return frame;
}

nlohmann::json RenderSession::statistics(const PassReport& report, StopReason reason) const {
    const RayStatistics rays = Intersector::statistics();
    const int threads = tbb::this_task_arena::max_concurrency();
    const double seconds = report.seconds;
    nlohmann::json nonFinite = nlohmann::json::object();
    for (int i = 0; i < static_cast<int>(Technique::Count); ++i)
        nonFinite[techniqueName(static_cast<Technique>(i))] = film_.nonFinite(static_cast<Technique>(i));
    const FilmWindow& w = film_.window();
    return {
        {"version", options_.version},
        {"scene", scene_.parts().source},
        {"integrator", options_.integrator},
        {"seed", options_.integratorOptions.seed},
        {"threads", threads},
        {"window", {{"x", w.x}, {"y", w.y}, {"width", w.width}, {"height", w.height}}},
        {"image", {{"width", w.fullWidth}, {"height", w.fullHeight}}},
        {"stop_reason", stopReasonName(reason)},
        {"passes", report.passes},
        {"seconds", seconds},
        {"seconds_for_aovs", secondsForAovs_},
        {"relative_error", numberOrNull(report.passes > 0 ? report.relativeError : kInfinity)},
        {"rays",
         {{"intersect", rays.intersectRays},
          {"shadow", rays.shadowRays},
          {"per_second",
           seconds > 0 ? static_cast<double>(rays.intersectRays + rays.shadowRays) / seconds : 0.0},
          {"share_of_time", seconds > 0 ? rays.secondsInEmbree / (seconds * threads) : 0.0}}},
        {"peak_memory_bytes", peakMemoryBytes()},
        {"non_finite", nonFinite},
        {"integrator_statistics", integrator_->statistics()},
    };
}

}  // namespace metrolux
