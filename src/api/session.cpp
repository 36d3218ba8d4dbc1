#include "api/internals.h"
#include "api/log.h"

#include <metrolux/version.h>

#include <algorithm>

namespace metrolux {
namespace {

core::SliceChoice slicesOf(const Slices& slices) {
    if (slices.count < 1 || slices.count > core::kMostSlices)
        throw core::Error("found {} slices, expected 1 to {}", slices.count, core::kMostSlices);
    const core::SliceChoice choice{slices.count, slices.first, slices.last.value_or(slices.count - 1)};
    if (choice.last >= choice.count || choice.first > choice.last)
        throw core::Error("slices {} to {} of {}: expected some of 0 to {}", choice.first, choice.last,
                          choice.count, choice.count - 1);
    return choice;
}

nlohmann::json sceneIdentity(const Scene::Impl& scene) {
    nlohmann::json identity = scene.identity;
    identity["files"] = core::fingerprints(scene.files, scene.stamps);
    return identity;
}

}  // namespace

core::SessionOptions core::api::coreOptions(const metrolux::Scene& scene,
                                            const metrolux::SessionOptions& options) {
    const metrolux::Scene::Impl& impl = Internals::of(scene);
    SessionOptions result;
    result.integrator = options.integrator;
    result.parameters = options.parameters;
    result.common.seed = options.seed;
    result.common.memoryBytes = options.memory;
    result.common.limits = impl.scene->parts().limits;
    if (options.maxDepth) result.common.limits.maxDepth = *options.maxDepth;
    for (const std::string& name : options.layers) result.aovs.push_back(core::aovFromName(name));
    result.version = version();
    result.scene = [scene] { return sceneIdentity(Internals::of(scene)); };
    result.slices = slicesOf(options.slices);
    return result;
}

namespace {

Progress progressOf(const core::PassReport& report, double raysPerSecond, const std::string& note) {
    return {report.passes,           report.seconds, report.relativeError,
            report.secondsRemaining, raysPerSecond,  note};
}

StopReason reasonOf(core::StopReason reason) {
    switch (reason) {
        case core::StopReason::Time:
            return StopReason::Time;
        case core::StopReason::Passes:
            return StopReason::Passes;
        case core::StopReason::Error:
            return StopReason::Error;
        case core::StopReason::Full:
            return StopReason::Full;
        case core::StopReason::Interrupted:
            break;
    }
    return StopReason::Interrupted;
}

}  // namespace

std::vector<core::NamedOutput> core::api::namedOutputs(const Files& files) {
    std::vector<NamedOutput> result;
    for (const std::filesystem::path& file : files.images)
        result.push_back({fmt::format("output '{}'", file.string()), file});
    if (files.checkpoint.empty()) return result;
    result.push_back({fmt::format("checkpoint '{}'", files.checkpoint.string()), files.checkpoint});
    const std::filesystem::path previous = previousCheckpoint(files.checkpoint);
    // A process that was killed while it wrote leaves both names on one file: nothing is lost then.
    std::error_code code;
    if (std::filesystem::equivalent(files.checkpoint, previous, code)) return result;
    result.push_back({fmt::format("the checkpoint before the last, '{}',", previous.string()), previous});
    return result;
}

core::RunOptions core::api::runOptions(const Limits& limits, const Files& files) {
    RunOptions run;
    run.limits = {limits.seconds, limits.passes, limits.relativeError};
    if (!limits.any()) run.limits.seconds = kDefaultSeconds;
    run.outputs = files.images;
    run.display = displayOf(files.display);
    run.overwrite = files.overwrite;
    run.saveEvery = files.saveEvery;
    run.checkpoint.file = files.checkpoint;
    run.checkpoint.every = files.checkpointEvery;
    run.checkpoint.command = files.command;
    run.checkpoint.folder = std::filesystem::current_path().string();
    return run;
}

core::RunHooks core::api::runHooks(const Hooks& hooks) {
    return {
        hooks.stop,
        [progress = hooks.progress](const PassReport& report, double raysPerSecond, const std::string& note) {
            if (progress) progress(progressOf(report, raysPerSecond, note));
        },
        [](const std::string& problem) { log(LogLevel::Warning, problem); }};
}

Outcome core::api::outcomeOf(const SessionResult& result) {
    return {reasonOf(result.reason), result.passes, result.written.failures, result.written.rescued,
            result.checkpointFailure};
}

Session::Impl::Impl(Scene s, SessionOptions o)
    : scene(std::move(s)), options(std::move(o)), workers(options.threads), session(workers.execute([this] {
          return std::make_unique<core::RenderSession>(Internals::of(scene).scene,
                                                       core::api::coreOptions(scene, options));
      })) {}

std::vector<IntegratorDescription> integrators() {
    std::vector<IntegratorDescription> result;
    for (const core::IntegratorDescription& integrator : core::integratorList()) {
        IntegratorDescription description{integrator.name, integrator.summary, {}};
        for (const core::ParameterInfo& p : integrator.parameters)
            description.parameters.push_back(
                {p.name, p.help, p.defaultValue, p.defaultText(), p.expected, p.choices, p.least, p.most});
        result.push_back(std::move(description));
    }
    return result;
}

Session::Session(Scene scene, SessionOptions options)
    : impl_(std::make_unique<Impl>(std::move(scene), std::move(options))) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

Progress Session::step() {
    impl_->workers.executeCancelable([this] { return impl_->session->step(); });
    return progress();
}

Outcome Session::render(const Limits& limits, const Hooks& hooks, const Files& files) {
    const core::RunOptions run = core::api::runOptions(limits, files);
    core::checkDistinct(core::api::namedOutputs(files), Internals::of(impl_->scene).files);
    core::RunHooks watch = core::api::runHooks(hooks);
    watch.interrupted = [&] { return impl_->stop.load() || (hooks.stop && hooks.stop()); };
    const core::SessionResult result =
        impl_->workers.executeCancelable([&] { return impl_->session->run(run, watch); });
    impl_->stop.store(false);
    return core::api::outcomeOf(result);
}

void Session::requestStop() noexcept { impl_->stop.store(true); }

Progress Session::progress() const {
    return progressOf(impl_->session->report(), impl_->session->raysPerSecond(),
                      impl_->session->progressNote());
}

ImageView Session::image() {
    const core::Film& film = impl_->session->film();
    impl_->image.resize(3 * static_cast<size_t>(film.pixelCount()));
    film.image(impl_->image);
    return {impl_->image.data(), film.height(), film.width(), 3};
}

ImageView Session::variance() {
    const core::Film& film = impl_->session->film();
    impl_->variance.resize(static_cast<size_t>(film.pixelCount()));
    film.variance(impl_->variance);
    return {impl_->variance.data(), film.height(), film.width(), 1};
}

namespace {

std::vector<float> denoisedPixels(core::RenderSession& session) {
    core::DenoisedImage image = session.denoised();
    for (const std::string& warning : image.warnings) core::api::log(LogLevel::Warning, warning);
    return std::move(image.layer.pixels);
}

}  // namespace

ImageView Session::layer(const std::string& name) {
    const std::vector<std::string>& known = impl_->options.layers;
    if (std::find(known.begin(), known.end(), name) == known.end())
        throw core::Error("the session has no layer '{}'; SessionOptions::layers names {}", name,
                          known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", ")));
    if (name == "variance") return variance();
    const core::Film& film = impl_->session->film();
    if (name == core::kDenoisedLayer) {
        const std::vector<float> pixels =
            impl_->workers.execute([this] { return denoisedPixels(*impl_->session); });
        impl_->denoised.resize(pixels.size());  // views stay where they are
        std::copy(pixels.begin(), pixels.end(), impl_->denoised.begin());
        return {impl_->denoised.data(), film.height(), film.width(), 3};
    }
    const auto* layers = impl_->workers.execute([this] { return &impl_->session->cameraLayers().layers; });
    const auto layer = std::find_if(layers->begin(), layers->end(),
                                    [&](const core::ImageLayer& l) { return l.name == name; });
    return {layer->pixels.data(), film.height(), film.width(), static_cast<int>(layer->channels.size())};
}

Picture Session::finish() && {
    const std::unique_ptr<Impl> impl = std::move(impl_);
    const core::Film& film = impl->session->film();
    const int height = film.height(), width = film.width();
    Picture picture{{std::move(impl->image), height, width, 3}, {}};
    picture.image.pixels.resize(3 * static_cast<size_t>(film.pixelCount()));
    film.image(picture.image.pixels);
    for (core::ImageLayer& layer : impl->workers.execute([&] { return impl->session->takeCameraLayers(); }))
        picture.layers[layer.name] = {std::move(layer.pixels), height, width,
                                      static_cast<int>(layer.channels.size())};
    const std::vector<std::string>& names = impl->options.layers;
    if (std::find(names.begin(), names.end(), core::kDenoisedLayer) != names.end())
        picture.layers[core::kDenoisedLayer] = {
            impl->workers.execute([&] { return denoisedPixels(*impl->session); }), height, width, 3};
    if (std::find(names.begin(), names.end(), "variance") != names.end()) {
        Image& variance = picture.layers["variance"];
        variance = {std::move(impl->variance), height, width, 1};
        variance.pixels.resize(static_cast<size_t>(film.pixelCount()));
        film.variance(variance.pixels);
    }
    return picture;
}

std::string Session::statistics() const {
    return impl_->workers.execute([this] { return impl_->session->statistics().dump(2); });
}

const Scene& Session::scene() const { return impl_->scene; }
const SessionOptions& Session::options() const { return impl_->options; }
const std::string& Session::integrator() const { return impl_->session->options().integrator; }
int Session::threads() const { return impl_->workers.threads(); }

void Session::saveImage(const std::filesystem::path& file, const Display& display) {
    Files files;
    files.images = {file};
    core::checkDistinct(core::api::namedOutputs(files), Internals::of(impl_->scene).files);
    const core::OutputSet output(files.images, core::api::displayOf(display), true);
    const core::RenderedFrame frame = impl_->workers.execute([this] { return impl_->session->frame(); });
    for (const std::string& warning : frame.warnings) core::api::log(LogLevel::Warning, warning);
    for (const std::string& failure : output.write(frame)) throw core::Error(failure);
}

void Session::save(const std::filesystem::path& checkpoint) const {
    Files files;
    files.checkpoint = checkpoint;
    core::checkDistinct(core::api::namedOutputs(files), Internals::of(impl_->scene).files);
    core::writeCheckpoint(checkpoint,
                          impl_->workers.execute([this] { return impl_->session->checkpoint({}); }));
}

void Session::resume(const std::filesystem::path& checkpoint, bool otherBuild) {
    if (impl_->session->film().passes() > 0)
        throw core::Error("the session has {} passes, expected none before it goes on from a checkpoint",
                          impl_->session->film().passes());
    Internals::restore(*this, core::readCheckpoint(checkpoint, version()), otherBuild);
}

void Internals::cancel(Session& session) noexcept { of(session).workers.cancel(); }

void Internals::restore(Session& session, core::Checkpoint checkpoint, bool otherBuild) {
    Session::Impl& impl = of(session);
    impl.workers.execute([&] { impl.session->restore(std::move(checkpoint), otherBuild); });
}

}  // namespace metrolux
