#pragma once
/// What the public types are made of, for the library itself and for the command where it does more than a
/// user of the library can (several processes).

#include "base/transform.h"
#include "io/scene_loader.h"
#include "render/session.h"
#include "render/threads.h"

#include <metrolux/scene.h>
#include <metrolux/session.h>

#include <atomic>

namespace metrolux {

struct Scene::Impl {
    std::shared_ptr<const core::Scene> scene;
    core::SensorSource sensor;
    core::LoadOptions film;  ///< what has been changed of the sensor's film
    PathChange paths;        ///< what has been changed of the integrator's limits
    std::shared_ptr<const core::mitsuba::ParsedScene> tree;  ///< what it was made from
    core::mitsuba::ElementPtr treeSensor;                    ///< of it, which `sensor` may stand for
    std::vector<std::filesystem::path> files;
    std::vector<core::FileStamp> stamps;  ///< of `files` as they were read
    std::vector<std::string> warnings;
    nlohmann::json identity;  ///< of the scene, but for the contents of `files`
};

struct Session::Impl {
    Scene scene;
    SessionOptions options;
    core::Workers workers;
    std::unique_ptr<core::RenderSession> session;
    std::vector<float> image, variance, denoised;  ///< what views show
    std::atomic<bool> stop{false};

    Impl(Scene s, SessionOptions o);
};

struct Internals {
    static core::Transform transform(const Transform& t);
    static Transform transform(const core::Transform& t);
    static const Scene::Impl& of(const Scene& scene) { return *scene.impl_; }
    static Scene wrap(Scene::Impl impl) {
        return Scene(std::make_shared<const Scene::Impl>(std::move(impl)));
    }
    static Session::Impl& of(Session& session) { return *session.impl_; }
    /// Drops the pass in progress within milliseconds: step() or render() throws core::Canceled, and the
    /// session is of no use any more. Any thread may call it while the session exists.
    static void cancel(Session& session) noexcept;
    /// As Session::resume(), from what has been read.
    static void restore(Session& session, core::Checkpoint checkpoint, bool otherBuild);
};

namespace core::api {

LoadOptions coreOptions(const metrolux::LoadOptions& options);
/// What follows loadScene() wherever a scene is read: its <integrator> is judged, and warnings are refused if
/// `strict`. Throws Error.
void settle(SceneParts& parts, const LoadOptions& options);
/// All files that a run writes, the one that keeps the checkpoint before the last among them.
std::vector<NamedOutput> namedOutputs(const Files& files);
SessionOptions coreOptions(const metrolux::Scene& scene, const metrolux::SessionOptions& options);
/// When a run ends and what it writes. Throws Error for an unknown curve.
RunOptions runOptions(const Limits& limits, const Files& files);
RunHooks runHooks(const Hooks& hooks);
Outcome outcomeOf(const SessionResult& result);
OutputSet::Display displayOf(const Display& display);

}  // namespace core::api
}  // namespace metrolux
