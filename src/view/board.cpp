#include "view/board.h"

#include "base/clock.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace metrolux::core::view {
namespace {

/// Seconds that a viewer is believed to be there: longer than one waits for news.
constexpr double kAttention = 30;
/// Least time between frames; the share of the time that they may take sets more where they are slow.
constexpr double kFrameInterval = 0.1, kShareOfTime = 0.01, kShareUnwatched = 0.002;
constexpr size_t kMostCommands = 64, kMostPoints = 256;

/// Of two sides the other one goes on when the integrator of one is changed.
bool isUrgent(const Command& command, size_t sides) {
    using Kind = Command::Kind;
    return command.kind == Kind::Move || command.kind == Kind::ResetCamera || command.kind == Kind::Crop ||
           (command.kind == Kind::Integrator && sides == 1);
}

/// Where there are too many points, every other one is enough.
void addPoint(std::vector<std::pair<double, double>>& curve, double seconds, double error) {
    if (!std::isfinite(error)) return;
    curve.emplace_back(seconds, error);
    if (curve.size() < kMostPoints) return;
    for (size_t i = 0; 2 * i < curve.size(); ++i) curve[i] = curve[2 * i];
    curve.resize((curve.size() + 1) / 2);
}

}  // namespace

const char* phaseName(Phase phase) {
    switch (phase) {
        case Phase::Loading:
            return "loading";
        case Phase::Rendering:
            return "rendering";
        case Phase::Paused:
            return "paused";
        case Phase::Stopped:
            return "stopped";
        case Phase::Done:
            return "done";
        case Phase::Ended:
            break;
    }
    return "ended";
}

CameraMotion& CameraMotion::operator+=(const CameraMotion& later) {
    yaw += later.yaw;
    pitch += later.pitch;
    dolly *= later.dolly;
    right += later.right;
    up += later.up;
    return *this;
}

void Board::onChange(std::function<void()> changed) {
    const std::lock_guard lock(mutex_);
    changed_ = std::move(changed);
}

void Board::onUrgent(std::function<void()> urgent) {
    const std::lock_guard lock(mutex_);
    urgent_ = std::move(urgent);
}

/// `lock` is released: whoever is told may ask.
void Board::changed(std::unique_lock<std::mutex>& lock) {
    ++state_.version;
    const std::function<void()> tell = changed_;
    lock.unlock();
    if (tell) tell();
}

bool Board::post(Command command) {
    std::unique_lock lock(mutex_);
    if (command.kind == Command::Kind::Move && !commands_.empty() &&
        commands_.back().kind == Command::Kind::Move && !command.motion.begins) {
        commands_.back().motion += command.motion;
    } else {
        if (commands_.size() >= kMostCommands) return false;
        commands_.push_back(command);
    }
    hasCommands_ = true;
    if (isUrgent(command, state_.sides.size()) && urgent_) urgent_();
    wake_.notify_all();
    return true;
}

BoardState Board::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

void Board::watch(bool variance) {
    const std::lock_guard lock(mutex_);
    watchedUntil_ = steadySeconds() + kAttention;
    if (!variance) return;
    varianceUntil_ = watchedUntil_;
    wake_.notify_all();
}

std::shared_ptr<const LayerPixels> Board::layer(int side, const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto found = layers_.find({side, name});
    if (found != layers_.end()) return found->second;
    wishes_.emplace(side, name);
    wake_.notify_all();
    return nullptr;
}

std::vector<Command> Board::take() {
    const std::lock_guard lock(mutex_);
    hasCommands_ = false;
    return std::exchange(commands_, {});
}

void Board::wait(double seconds) {
    std::unique_lock lock(mutex_);
    if (commands_.empty() && wishes_.empty()) wake_.wait_for(lock, std::chrono::duration<double>(seconds));
}

void Board::change(const std::function<void(BoardState&)>& change) {
    std::unique_lock lock(mutex_);
    change(state_);
    changed(lock);
}

void Board::tell(std::string message, bool isError) {
    change([&](BoardState& state) {
        ++state.messageNumber;
        state.message = std::move(message);
        state.messageIsError = isError;
    });
}

void Board::pass(int side, const Progress& progress) {
    std::unique_lock lock(mutex_);
    SideState& s = state_.sides[static_cast<size_t>(side)];
    s.progress = progress;
    addPoint(s.curve, progress.seconds, progress.relativeError);
    // Passes may be shorter than anybody can read.
    const double now = steadySeconds();
    if (now < nextPass_) return;
    nextPass_ = now + kFrameInterval;
    changed(lock);
}

bool Board::isDue(int side) const {
    const std::lock_guard lock(mutex_);
    const double now = steadySeconds();
    const Made& last = lastFrame_[static_cast<size_t>(side)];
    const double share = always_ || now < watchedUntil_ ? kShareOfTime : kShareUnwatched;
    return now >= last.at + std::max(kFrameInterval, last.seconds / share);
}

bool Board::isWatched() const {
    const std::lock_guard lock(mutex_);
    return steadySeconds() < watchedUntil_;
}

bool Board::wantsVariance() const {
    const std::lock_guard lock(mutex_);
    return steadySeconds() < varianceUntil_;
}

bool Board::lacksVariance() const {
    const std::lock_guard lock(mutex_);
    if (steadySeconds() >= varianceUntil_) return false;
    return std::any_of(state_.sides.begin(), state_.sides.end(), [](const SideState& s) {
        return s.frame && s.frame->scale == 1 && s.frame->variance.empty();
    });
}

void Board::publish(int side, Frame frame, double secondsToMake) {
    std::unique_lock lock(mutex_);
    SideState& s = state_.sides[static_cast<size_t>(side)];
    frame.version = ++frames_;
    frame.generation = s.generation;
    s.frame = std::make_shared<const Frame>(std::move(frame));
    lastFrame_[static_cast<size_t>(side)] = {steadySeconds(), secondsToMake};
    changed(lock);
}

std::vector<std::pair<int, std::string>> Board::wishes() const {
    const std::lock_guard lock(mutex_);
    return {wishes_.begin(), wishes_.end()};
}

void Board::fulfill(int side, const std::string& name, LayerPixels pixels) {
    std::unique_lock lock(mutex_);
    wishes_.erase({side, name});
    layers_[{side, name}] = std::make_shared<const LayerPixels>(std::move(pixels));
    changed(lock);
}

void Board::forgetLayers() {
    const std::lock_guard lock(mutex_);
    layers_.clear();
    wishes_.clear();
}

}  // namespace metrolux::core::view
