#pragma once
/// The renderings of `metrolux view`: what viewers ask for is done between passes, and a new camera, crop or
/// integrator ends the pass in progress.

#include "view/board.h"
#include "view/camera_motion.h"

#include <mutex>

namespace metrolux::core::view {

struct ExplorerOptions {
    metrolux::SessionOptions session;  ///< of the first side; the other has the same, but for the integrator
    Limits limits;                     ///< without any: until somebody stops it
    /// For saving. Without a checkpoint only the last, by saving, is written: beside the first image.
    Files files;
    std::function<bool()> interrupted;  ///< asked between passes
};

class Explorer {
  public:
    Explorer(metrolux::Scene scene, ExplorerOptions options, Board& board);
    ~Explorer();
    Explorer(const Explorer&) = delete;
    Explorer& operator=(const Explorer&) = delete;

    struct Result {
        Outcome outcome;         ///< of the first side
        std::string statistics;  ///< JSON; empty without a pass
    };
    /// Renders until it is interrupted, then writes the files of the first side. Throws Error when the first
    /// rendering cannot be.
    Result run();

  private:
    /// An integrator on the scene. A restart begins with previews, each of which has twice the resolution of
    /// the one before.
    struct Side {
        metrolux::SessionOptions options;
        std::vector<int> scales;                    ///< that are still to be rendered, the last is 1
        bool isFirst = true;                        ///< preview since the restart, which is not abandoned
        std::optional<Session> session;             ///< of the full resolution
        std::optional<metrolux::StopReason> ended;  ///< a limit was reached
        double secondsPerPixel = 0;                 ///< of a pass; 0: not known
        double seconds = 0;                         ///< of this side's work since the restart
    };

    void execute(const Command& command);
    void move(const metrolux::Scene& scene);
    void choose(size_t side, const std::string& integrator);
    void compare(const std::string& integrator);
    void restart();
    void restart(Side& side);
    void setPhase(Phase phase, const std::string& reason = {});
    void grantWishes();
    void save();
    Outcome write(Side& side, const Files& files);
    Side* next();
    void render(Side& side);
    void renderPreview(Side& side, int scale);
    void renderFull(Side& side);
    int indexOf(const Side& side) const { return static_cast<int>(&side - sides_.data()); }
    bool isBothered() const { return board_.hasCommands() || options_.interrupted(); }
    /// While it lives, an urgent command ends the pass in progress.
    class Cancelable;

    metrolux::Scene initial_, scene_;
    ExplorerOptions options_;
    Board& board_;
    CameraHandle camera_;
    std::vector<Side> sides_;
    bool paused_ = false, stopped_ = false, begun_ = false;
    std::mutex mutex_;
    Session* cancelable_ = nullptr;  ///< guarded by mutex_
};

}  // namespace metrolux::core::view
