#pragma once
/// Renders a scene from the first pass to the files on disk.

#include "integrators/scene_choice.h"
#include "render/aov.h"
#include "render/checkpoint.h"
#include "render/output.h"
#include "render/pass_loop.h"
#include "render/progress.h"
#include "render/streams.h"
#include "render/team.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

/// Where and when the state is saved, and what a later process needs to know.
struct CheckpointOptions {
    std::filesystem::path file;        ///< empty: no checkpoints
    double every = 300;                ///< seconds between two; the last is written at the end
    std::vector<std::string> command;  ///< Checkpoint::command
    std::string folder;                ///< Checkpoint::folder
    nlohmann::json scene;              ///< part of the identity: files and options of the scene
};

struct SessionOptions {
    std::string integrator = kDefaultIntegrator;  ///< as for chooseIntegrator()
    ParameterValues parameters;                   ///< in place of the scene's and of the defaults
    CommonOptions common;
    RenderLimits limits;
    std::vector<std::filesystem::path> outputs;
    OutputSet::Display display;
    bool overwrite = false;  ///< images of other programs too
    std::vector<Aov> aovs;
    double saveEvery = 60;  ///< seconds between intermediate images; 0: none
    std::string version;    ///< for statistics and metadata
    CheckpointOptions checkpoint;
    int rank = 0;          ///< in a team: files are written by rank 0
    StreamChoice streams;  ///< limits.passes are those of all streams together
};

struct SessionResult {
    StopReason reason = StopReason::Interrupted;
    uint32_t passes = 0;              ///< 0: interrupted before there was an image, nothing was written
    OutputSet::RescueResult written;  ///< of the final image
    std::string checkpointFailure;    ///< of the last checkpoint; empty: it is there, or none was wanted
    nlohmann::json statistics;
};

/// Contributions that were not finite, by technique, for statistics.
nlohmann::json nonFiniteCounts(const Film& film);

class RenderSession {
  public:
    /// Throws Error when the integrator is unknown or an output could not be written: before any work is
    /// done.
    RenderSession(const Scene& scene, SessionOptions options);
    /// With an integrator made elsewhere; options.integrator is its name in the statistics.
    RenderSession(const Scene& scene, SessionOptions options, std::unique_ptr<Integrator> integrator);

    /// Renders until a limit is reached or `interrupted` says so (asked between passes), and writes the
    /// files.
    ///
    /// A checkpoint that cannot be written is warned of and tried again after the next interval.
    SessionResult run(ProgressReporter& progress, const std::function<bool()>& interrupted);

    /// As run(), together with other processes, which share the streams; all of them call it. Rank 0 writes
    /// the files and has the result, the others' only says why they stopped. There is no error limit.
    SessionResult runTogether(Team& team, ProgressReporter& progress,
                              const std::function<bool()>& interrupted);

    /// What the image depends on, scene files and options: Checkpoint::identity.
    nlohmann::json identity() const;
    /// Before run(): goes on from a checkpoint. Throws Error when it is one of another rendering.
    void restore(Checkpoint checkpoint);

  private:
    RenderSession(const Scene& scene, SessionOptions options, const IntegratorChoice& choice);
    RenderSession(const Scene& scene, SessionOptions options, nlohmann::json parameters,
                  StreamedIntegrator::Make make);
    /// What has been rendered, by this process or by a team.
    struct Snapshot {
        const Film& film;
        PassReport report;
        RayStatistics rays;
        std::function<std::vector<StreamState>()> streams;
    };
    Snapshot here(const PassReport& report) const;
    RenderedFrame frame(const Snapshot& now) const;
    nlohmann::json statistics(const Snapshot& now, StopReason reason) const;
    void saveWhatIsDue(const Snapshot& now, ProgressReporter& progress);
    void saveCheckpoint(const Snapshot& now, ProgressReporter& progress);
    void conclude(const Snapshot& end, SessionResult& result, ProgressReporter& progress);
    Checkpoint checkpoint(const Snapshot& now) const;
    void begin();
    void shareStreams(Team& team);
    void report(const TeamResult& all, double seconds, SessionResult& result, ProgressReporter& progress);
    std::unique_ptr<Film> merged(const TeamResult& result) const;
    RayStatistics rays() const;

    const Scene& scene_;
    SessionOptions options_;
    nlohmann::json parameters_;  ///< of the integrator, by name
    OutputSet outputs_;
    Film film_;
    StreamedIntegrator integrator_;
    std::vector<ImageLayer> cameraLayers_;
    double nextSave_ = 0, nextCheckpoint_ = 0, secondsForAovs_ = 0;
    double secondsBefore_ = 0;  ///< of the processes before this one
    RayStatistics raysBefore_;
    std::string checkpointFailure_;
};

}  // namespace metrolux::core
