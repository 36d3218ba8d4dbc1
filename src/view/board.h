#pragma once
/// Where the thread that renders and those that serve viewers meet. Neither waits for the other.

#include "view/frame.h"

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace metrolux::core::view {

/// Two integrators may be seen side by side.
inline constexpr int kSides = 2;

enum class Phase { Loading, Rendering, Paused, Stopped, Done, Ended };
const char* phaseName(Phase phase);

/// By how much the camera is to be moved.
struct CameraMotion {
    bool begins = false;        ///< of a drag: the point in the middle of the image becomes the pivot
    double yaw = 0, pitch = 0;  ///< radians around the pivot
    double dolly = 1;           ///< factor of the distance to the pivot
    double right = 0, up = 0;   ///< in widths of the full image, at the pivot
    CameraMotion& operator+=(const CameraMotion& later);
};

/// What viewers may ask for.
struct Command {
    enum class Kind { Pause, Resume, Stop, Save, Move, ResetCamera, Crop, Integrator, Compare };
    Kind kind = Kind::Pause;
    CameraMotion motion;
    std::optional<metrolux::Crop> crop;  ///< none: the full image
    std::string integrator;              ///< Compare: empty for no second side
};

/// What a viewer is told of a side.
struct SideState {
    std::string integrator;
    uint64_t generation = 0;  ///< grows where pixels of before are of something else
    Progress progress;
    std::vector<std::pair<double, double>> curve;  ///< seconds, estimated relative error
    std::shared_ptr<const Frame> frame;            ///< null before the first
};

struct BoardState {
    uint64_t version = 0;  ///< grows with every change
    Phase phase = Phase::Loading;
    std::string reason;  ///< why it is done
    uint64_t messageNumber = 0;
    std::string message;  ///< the last thing to be told
    bool messageIsError = false;
    Resolution resolution;
    Crop window;
    std::array<double, 16> camera{};  ///< to_world, row by row
    std::vector<SideState> sides;
};

/// What never changes.
struct BoardInfo {
    std::string scene;
    bool explores = false;            ///< camera, crop and integrators may be changed
    std::vector<std::string> layers;  ///< of the camera's first surfaces that can be had
    std::vector<std::string> outputs;
};

class Board {
  public:
    explicit Board(BoardInfo info) : info_(std::move(info)) {}
    const BoardInfo& info() const { return info_; }

    // For those who serve viewers. `changed` is called after each change by whoever made it.
    void onChange(std::function<void()> changed);
    /// `urgent`: called for a command that makes the pass in progress worthless.
    void onUrgent(std::function<void()> urgent);
    /// False: there are too many already.
    bool post(Command command);
    BoardState state() const;
    /// Somebody looks, and for a while frames are made; with `variance` those have it.
    void watch(bool variance);
    /// Null if it is not there yet, and then it is asked for.
    std::shared_ptr<const LayerPixels> layer(int side, const std::string& name);

    // For the thread that renders.
    bool hasCommands() const noexcept { return hasCommands_.load(std::memory_order_relaxed); }
    std::vector<Command> take();
    /// Returns early when there are commands or wishes.
    void wait(double seconds);
    void change(const std::function<void(BoardState&)>& change);
    void tell(std::string message, bool isError = false);
    void pass(int side, const Progress& progress);
    /// Whether it is time for a frame. While somebody looks, frames take at most 1 % of the time, else 0.2 %,
    /// so that there is one for who comes.
    bool isDue(int side) const;
    bool isWatched() const;
    bool wantsVariance() const;
    /// That of somebody who looks and the last frame lacks, when no pass is going to bring a frame.
    bool lacksVariance() const;
    void publish(int side, Frame frame, double secondsToMake);
    std::vector<std::pair<int, std::string>> wishes() const;
    void fulfill(int side, const std::string& name, LayerPixels pixels);
    void forgetLayers();
    /// Viewers do not count: frames are wanted always.
    void wantAlways() { always_ = true; }

  private:
    void changed(std::unique_lock<std::mutex>& lock);
    const BoardInfo info_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    std::function<void()> changed_, urgent_;
    BoardState state_;
    std::vector<Command> commands_;
    std::atomic<bool> hasCommands_{false}, always_{false};
    std::map<std::pair<int, std::string>, std::shared_ptr<const LayerPixels>> layers_;
    std::set<std::pair<int, std::string>> wishes_;
    uint64_t frames_ = 0;
    double watchedUntil_ = 0, varianceUntil_ = 0, nextPass_ = 0;
    struct Made {
        double at = -1e9, seconds = 0;
    };
    std::array<Made, kSides> lastFrame_;
};

}  // namespace metrolux::core::view
