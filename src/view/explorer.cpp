#include "view/explorer.h"

#include "api/internals.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/parallel.h"
#include "render/aov.h"
#include "view/frames.h"

#include <fmt/format.h>

#include <algorithm>

namespace metrolux::core::view {
namespace {

/// Without a limit; a hundred years.
constexpr double kForever = 3.2e9;
/// What the first preview may take, and what a pixel takes before it is known.
constexpr double kFirstPreview = 0.12, kSecondsPerPixel = 1e-5;
constexpr int kCoarsest = 16;
/// Seconds between looks whether somebody interrupts, where nothing is rendered.
constexpr double kIdle = 0.1;

const char* reasonText(metrolux::StopReason reason) {
    switch (reason) {
        case metrolux::StopReason::Time:
            return "the time limit is reached";
        case metrolux::StopReason::Passes:
            return "the number of passes is reached";
        case metrolux::StopReason::Error:
            return "the wanted error is reached";
        case metrolux::StopReason::Full:
            return "a rendering takes no more passes";
        case metrolux::StopReason::Interrupted:
            break;
    }
    return "interrupted";
}

std::filesystem::path named(const std::filesystem::path& file, const std::string& integrator) {
    std::filesystem::path result = file;
    result.replace_extension("." + integrator + file.extension().string());
    return result;
}

}  // namespace

class Explorer::Cancelable {
  public:
    Cancelable(Explorer& explorer, Session& session) : explorer_(explorer) {
        const std::lock_guard lock(explorer_.mutex_);
        explorer_.cancelable_ = &session;
    }
    ~Cancelable() {
        const std::lock_guard lock(explorer_.mutex_);
        explorer_.cancelable_ = nullptr;
    }
    Cancelable(const Cancelable&) = delete;
    Cancelable& operator=(const Cancelable&) = delete;

  private:
    Explorer& explorer_;
};

Explorer::Explorer(metrolux::Scene scene, ExplorerOptions options, Board& board)
    : initial_(scene),
      scene_(std::move(scene)),
      options_(std::move(options)),
      board_(board),
      camera_(scene_) {
    if (!options_.limits.any()) options_.limits.seconds = kForever;
    sides_.reserve(kSides);
    sides_.push_back({});
    sides_[0].options = options_.session;
    board_.onUrgent([this] {
        const std::lock_guard lock(mutex_);
        if (cancelable_) Internals::cancel(*cancelable_);
    });
}

Explorer::~Explorer() { board_.onUrgent({}); }

void Explorer::setPhase(Phase phase, const std::string& reason) {
    board_.change([&](BoardState& state) {
        state.phase = phase;
        state.reason = reason;
    });
}

void Explorer::restart() {
    for (Side& side : sides_) restart(side);
}

/// Previews are worth their time where a pass takes long: together they take a third of a pass at most.
void Explorer::restart(Side& side) {
    side.session.reset();
    side.ended.reset();
    side.seconds = 0;
    side.isFirst = true;
    const Crop window = scene_.window();
    const double perPixel = side.secondsPerPixel > 0 ? side.secondsPerPixel : kSecondsPerPixel;
    const double pass = perPixel * double(window.width) * double(window.height);
    int scale = 1;
    while (scale < kCoarsest && pass / (double(scale) * scale) > kFirstPreview &&
           std::min(window.width, window.height) / (2 * scale) >= 8)
        scale *= 2;
    side.scales.clear();
    for (; scale >= 1; scale /= 2) side.scales.push_back(scale);
    board_.forgetLayers();
    board_.change([&](BoardState& state) {
        state.sides.resize(sides_.size());
        state.resolution = scene_.resolution();
        state.window = window;
        state.camera = cameraOf(scene_).rows();
        beginSide(state.sides[static_cast<size_t>(indexOf(side))], side.options.integrator);
    });
}

Explorer::Result Explorer::run() {
    restart();
    setPhase(Phase::Rendering);
    while (!options_.interrupted()) {
        for (const Command& command : board_.take()) {
            try {
                execute(command);
            } catch (const Error& problem) {
                board_.tell(problem.what(), true);
            }
        }
        grantWishes();
        if (Side* side = paused_ || stopped_ ? nullptr : next())
            render(*side);
        else
            board_.wait(kIdle);
    }
    Side& first = sides_[0];
    Result result;
    if (!first.session || first.session->progress().passes == 0) return result;
    result.outcome = write(first, options_.files);
    result.statistics = first.session->statistics();
    return result;
}

void Explorer::execute(const Command& command) {
    using Kind = Command::Kind;
    switch (command.kind) {
        case Kind::Pause:
            paused_ = true;
            setPhase(Phase::Paused);
            break;
        case Kind::Resume:
            paused_ = stopped_ = false;
            if (next()) setPhase(Phase::Rendering);
            break;
        case Kind::Stop:
            stopped_ = true;
            setPhase(Phase::Stopped);
            break;
        case Kind::Save:
            save();
            break;
        case Kind::Move:
            move(scene_.withCamera(camera_.moved(scene_, command.motion)));
            break;
        case Kind::ResetCamera:
            move(scene_.withCamera(cameraOf(initial_)));
            break;
        case Kind::Crop: {
            const Resolution full = scene_.resolution();
            FilmChange change;
            change.crop = command.crop.value_or(metrolux::Crop{0, 0, full.width, full.height});
            move(scene_.withFilm(change));
            break;
        }
        case Kind::Integrator:
            choose(0, command.integrator);
            break;
        case Kind::Compare:
            compare(command.integrator);
            break;
    }
    // What nobody renders any more is shown as it is at the end.
    if (paused_ || stopped_)
        for (Side& side : sides_)
            if (side.session && side.session->progress().passes > 0)
                publish(board_, indexOf(side), *side.session);
}

/// Another view of the scene.
void Explorer::move(const metrolux::Scene& scene) {
    scene_ = scene;
    restart();
    paused_ = stopped_ = false;
    setPhase(Phase::Rendering);
}

void Explorer::choose(size_t side, const std::string& integrator) {
    metrolux::SessionOptions& options = sides_[side].options;
    options.integrator = integrator;
    // Parameters that another integrator has, too, stay.
    const std::vector<metrolux::IntegratorDescription> all = metrolux::integrators();
    const auto description =
        std::find_if(all.begin(), all.end(),
                     [&](const metrolux::IntegratorDescription& i) { return i.name == integrator; });
    options.parameters = options_.session.parameters;
    std::erase_if(options.parameters, [&](const auto& given) {
        return description == all.end() ||
               std::none_of(description->parameters.begin(), description->parameters.end(),
                            [&](const metrolux::ParameterDescription& p) { return p.name == given.first; });
    });
    sides_[side].secondsPerPixel = 0;
    restart(sides_[side]);
    paused_ = stopped_ = false;
    setPhase(Phase::Rendering);
}

void Explorer::compare(const std::string& integrator) {
    if (integrator.empty()) {
        sides_.resize(1);
        board_.change([](BoardState& state) { state.sides.resize(1); });
        return;
    }
    if (sides_.size() < kSides) {
        sides_.push_back({});
        sides_.back().options = options_.session;
    }
    choose(1, integrator);
}

/// Whose turn it is: previews go first, then who has worked less. Both sides so get the same time.
Explorer::Side* Explorer::next() {
    Side* chosen = nullptr;
    for (Side& side : sides_) {
        if (side.ended) continue;
        const auto rank = [](const Side& s) { return std::pair(s.scales.size() <= 1, s.seconds); };
        if (!chosen || rank(side) < rank(*chosen)) chosen = &side;
    }
    return chosen;
}

void Explorer::render(Side& side) {
    const double start = steadySeconds();
    try {
        if (side.scales.size() > 1) {
            renderPreview(side, side.scales.front());
            side.scales.erase(side.scales.begin());
        } else {
            renderFull(side);
        }
        begun_ = true;
    } catch (const Canceled&) {
        restart(side);  // the command that did it is next
    } catch (const Error& problem) {
        if (!begun_) throw;
        side.ended = metrolux::StopReason::Interrupted;
        board_.tell(fmt::format("{}: {}", side.options.integrator, problem.what()), true);
    }
    side.seconds += steadySeconds() - start;
}

void Explorer::renderPreview(Side& side, int scale) {
    const Resolution full = scene_.resolution();
    FilmChange change;
    change.resolution = Resolution{std::max(1, full.width / scale), std::max(1, full.height / scale)};
    Session session(scene_.withFilm(change), side.options);
    std::optional<Cancelable> cancelable;
    if (!side.isFirst) cancelable.emplace(*this, session);
    const Progress progress = session.step();
    const Crop window = session.scene().window();
    side.secondsPerPixel = progress.seconds / (double(window.width) * double(window.height));
    side.isFirst = false;
    publish(board_, indexOf(side), session, scale);
}

/// Passes until somebody wants something, or it is the other side's turn.
void Explorer::renderFull(Side& side) {
    if (!side.session) side.session.emplace(scene_, side.options);
    Session& session = *side.session;
    const Cancelable cancelable(*this, session);
    const uint32_t before = session.progress().passes;
    const int index = indexOf(side);
    Hooks hooks;
    hooks.progress = [&](const Progress& progress) {
        // A frame of the first passes replaces the previews.
        board_.pass(index, progress);
        if (progress.passes == 1 || board_.isDue(index)) publish(board_, index, session);
        grantWishes();
    };
    hooks.stop = [&] { return isBothered() || (sides_.size() > 1 && session.progress().passes > before); };
    const Outcome outcome = session.render(options_.limits, hooks);
    const Progress progress = session.progress();
    if (progress.passes > 0 && progress.passes <= 4) {
        const Crop w = scene_.window();
        side.secondsPerPixel = progress.seconds / (double(progress.passes) * w.width * w.height);
    }
    if (outcome.reason == metrolux::StopReason::Interrupted) return;
    side.ended = outcome.reason;
    publish(board_, index, session);
    if (std::all_of(sides_.begin(), sides_.end(), [](const Side& s) { return s.ended.has_value(); }))
        setPhase(Phase::Done, reasonText(outcome.reason));
}

/// Layers that viewers want to see, and the variance where no pass is going to bring it.
void Explorer::grantWishes() {
    for (const auto& [side, name] : board_.wishes()) {
        const core::Scene& inside = *Internals::of(scene_).scene;
        const std::vector<ImageLayer> layers = renderAovs(inside, {aovFromName(name)}).layers;
        const FilmWindow& w = inside.camera().window();
        board_.fulfill(
            side, name,
            {w.width, w.height, static_cast<int>(layers.at(0).channels.size()), layers.at(0).pixels});
    }
    if (!board_.lacksVariance()) return;
    for (Side& side : sides_)
        if (side.session && (paused_ || stopped_ || side.ended) && side.session->progress().passes > 0)
            publish(board_, indexOf(side), *side.session);
}

void Explorer::save() {
    for (Side& side : sides_) {
        if (!side.session || side.session->progress().passes == 0) {
            board_.tell("there is nothing to save before the first pass", true);
            continue;
        }
        Files files = options_.files;
        if (files.checkpoint.empty() && !files.images.empty())
            files.checkpoint = std::filesystem::path(files.images[0]).replace_extension(".checkpoint");
        if (&side != sides_.data()) {
            for (std::filesystem::path& file : files.images) file = named(file, side.options.integrator);
            files.checkpoint = named(files.checkpoint, side.options.integrator);
        }
        tellOfFiles(board_, write(side, files), files);
    }
}

/// A rendering of no passes: the files are written by the rules for those of `render`. The checkpoint is one
/// for `metrolux resume` as long as the command line says what is rendered.
Outcome Explorer::write(Side& side, const Files& files) {
    Files written = files;
    const bool asCommanded =
        &side == sides_.data() && side.options.integrator == options_.session.integrator &&
        cameraOf(scene_).rows() == cameraOf(initial_).rows() &&
        scene_.window().width == initial_.window().width &&
        scene_.window().height == initial_.window().height && scene_.window().x == initial_.window().x &&
        scene_.window().y == initial_.window().y;
    if (!asCommanded) written.command.clear();
    Hooks hooks;
    hooks.stop = [] { return true; };
    return side.session->render(options_.limits, hooks, written);
}

}  // namespace metrolux::core::view
