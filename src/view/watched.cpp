#include "view/watched.h"

#include "view/camera_motion.h"
#include "view/frames.h"

namespace metrolux::core::view {
namespace {

/// Seconds between looks whether a pause has ended.
constexpr double kIdle = 0.1;

class Watched {
  public:
    Watched(Session& session, const Limits& limits, const Hooks& hooks, const Files& files, Board& board)
        : session_(session), limits_(limits), hooks_(hooks), files_(files), board_(board) {}

    Outcome run() {
        begin();
        Hooks watching;
        watching.progress = [this](const Progress& progress) {
            if (hooks_.progress) hooks_.progress(progress);
            afterPass(board_, 0, session_, progress);
            grantWishes();
        };
        watching.stop = [this] { return obey(); };
        while (true) {
            const Outcome outcome = session_.render(limits_, watching, files_);
            if (outcome.passes > 0) publish(board_, 0, session_);
            if (outcome.reason != metrolux::StopReason::Interrupted || ends()) {
                setPhase(outcome.reason == metrolux::StopReason::Interrupted ? Phase::Stopped : Phase::Done);
                return outcome;
            }
            tellOfFiles(board_, outcome, files_);
            saves_ = false;
            if (waitWhilePaused()) {
                setPhase(Phase::Stopped);
                return outcome;
            }
        }
    }

  private:
    void begin() {
        const metrolux::Scene& scene = session_.scene();
        board_.change([&](BoardState& state) {
            state.phase = Phase::Rendering;
            state.resolution = scene.resolution();
            state.window = scene.window();
            state.camera = cameraOf(scene).rows();
            state.sides.resize(1);
            beginSide(state.sides[0], session_.integrator());
        });
    }
    bool ends() const { return stops_ || (hooks_.stop && hooks_.stop()); }
    /// Whether the rendering has to come back.
    bool obey() {
        if (board_.hasCommands())
            for (const Command& command : board_.take()) {
                if (command.kind == Command::Kind::Pause) pauses_ = true;
                if (command.kind == Command::Kind::Resume) pauses_ = false;
                if (command.kind == Command::Kind::Stop) stops_ = true;
                if (command.kind == Command::Kind::Save) saves_ = true;
            }
        return pauses_ || saves_ || ends();
    }
    /// True: it has ended meanwhile.
    bool waitWhilePaused() {
        if (!pauses_) return false;
        setPhase(Phase::Paused);
        while (obey(), pauses_ && !saves_ && !ends()) {
            if (board_.lacksVariance()) publish(board_, 0, session_);
            grantWishes();
            board_.wait(kIdle);
        }
        if (ends()) return true;
        if (!pauses_) setPhase(Phase::Rendering);
        return false;
    }
    void setPhase(Phase phase) {
        board_.change([&](BoardState& state) { state.phase = phase; });
    }
    void grantWishes() {
        for (const auto& [side, name] : board_.wishes()) {
            const ImageView layer = session_.layer(name);
            board_.fulfill(
                side, name,
                {layer.width, layer.height, layer.channels, {layer.data, layer.data + layer.size()}});
        }
    }

    Session& session_;
    const Limits& limits_;
    const Hooks& hooks_;
    const Files& files_;
    Board& board_;
    bool pauses_ = false, stops_ = false, saves_ = false;
};

}  // namespace

Outcome renderWatched(Session& session, const Limits& limits, const Hooks& hooks, const Files& files,
                      Board& board) {
    return Watched(session, limits, hooks, files, board).run();
}

}  // namespace metrolux::core::view
