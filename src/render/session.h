#pragma once
/// Renders a scene from the first pass to the files on disk, or pass by pass.

#include "image/file_lock.h"
#include "integrators/scene_choice.h"
#include "render/aov.h"
#include "render/checkpoint.h"
#include "render/denoiser.h"
#include "render/output.h"
#include "render/pass_loop.h"
#include "render/slices.h"
#include "render/team.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <optional>

namespace metrolux::core {

/// What is rendered and how: the image depends on nothing else.
struct SessionOptions {
    std::string integrator = kDefaultIntegrator;  ///< as for chooseIntegrator()
    ParameterValues parameters;                   ///< in place of the scene's and of the defaults
    CommonOptions common;
    std::vector<Aov> aovs;
    std::string version;  ///< for statistics, metadata and checkpoints
    /// Files and options of the scene, for identity(), asked once; default: null.
    std::function<nlohmann::json()> scene;
    int rank = 0;        ///< in a team: files are written by rank 0
    SliceChoice slices;  ///< the passes of a limit are those of all slices together
};

/// Where and when the state is saved, and what a later process needs to know.
struct CheckpointOptions {
    std::filesystem::path file;              ///< empty: no checkpoints
    double every = kDefaultCheckpointEvery;  ///< seconds between two; the last is written at the end
    std::vector<std::string> command;        ///< Checkpoint::command
    std::string folder;                      ///< Checkpoint::folder
};

/// When a run ends, and what it writes.
struct RunOptions {
    RenderLimits limits;  ///< of all runs of the session together
    std::vector<std::filesystem::path> outputs;
    OutputSet::Display display;
    bool overwrite = false;                ///< images of other programs too
    double saveEvery = kDefaultSaveEvery;  ///< seconds between intermediate images; 0: none
    CheckpointOptions checkpoint;
};

/// Who watches a run. All are called by the thread that runs it, between passes.
struct RunHooks {
    std::function<bool()> interrupted;  ///< default: never
    std::function<void(const PassReport&, double raysPerSecond, const std::string& note)> afterPass;
    std::function<void(const std::string&)> warn;  ///< of what went wrong without ending the run
};

struct SessionResult {
    StopReason reason = StopReason::Interrupted;
    uint32_t passes = 0;              ///< 0: interrupted before there was an image, nothing was written
    OutputSet::RescueResult written;  ///< of the final image
    std::string checkpointFailure;    ///< of the last checkpoint; empty: it is there, or none was wanted
    nlohmann::json statistics;
};

/// By the names of the techniques, for statistics.
nlohmann::json toJson(const TechniqueCounts& counts);

/// A rendering in progress. It owns what it renders: the scene lives as long as one of its users does.
class RenderSession {
  public:
    /// Throws Error when the integrator is unknown or refuses the scene.
    RenderSession(const std::shared_ptr<const Scene>& scene, const SessionOptions& options);
    /// With an integrator made elsewhere; options.integrator is its name in the statistics.
    RenderSession(std::shared_ptr<const Scene> scene, SessionOptions options,
                  std::unique_ptr<Integrator> integrator);

    /// Renders until a limit is reached or somebody interrupts, and writes the files. May be called again
    /// with further limits. Throws Error when an output could not be written, before any work is done.
    ///
    /// A checkpoint that cannot be written is warned of and tried again after the next interval.
    SessionResult run(const RunOptions& options, const RunHooks& hooks);

    /// As run(), together with other processes, which share the slices; all of them call it. Rank 0 writes
    /// the files and has the result, the others' only says why they stopped. There is no error limit.
    SessionResult runTogether(Team& team, const RunOptions& options, const RunHooks& hooks);

    /// Renders one pass.
    PassReport step();

    /// What the image depends on, scene files and options: Checkpoint::identity.
    nlohmann::json identity() const;
    /// The part of it that names the algorithm.
    nlohmann::json algorithmIdentity() const;
    /// Before the first pass: goes on from a checkpoint. Throws Error when it is one of another rendering.
    /// `otherBuild`: of another build too, whose last bits could differ.
    void restore(Checkpoint checkpoint, bool otherBuild = false);
    /// The state between two passes. `options` name what a later process needs to know.
    Checkpoint checkpoint(const RunOptions& options);

    // What has been rendered so far.
    const Scene& scene() const { return *scene_; }
    const std::shared_ptr<const Scene>& sharedScene() const { return scene_; }
    const SessionOptions& options() const { return options_; }
    const Film& film() const { return film_; }
    PassReport report() const;
    double raysPerSecond() const;
    std::string progressNote() const { return integrator_.progressNote(); }
    nlohmann::json statistics() const;
    /// The image with its layers and metadata. Denoised if options().aovs says so.
    RenderedFrame frame();
    /// Layers of the camera's first surfaces, of those that options().aovs names; rendered at the first call.
    const CameraLayers& cameraLayers();
    /// The same to take away; a later call renders them again.
    std::vector<ImageLayer> takeCameraLayers();
    /// Without its noise; options().aovs names Aov::Denoised.
    DenoisedImage denoised();

  private:
    RenderSession(const std::shared_ptr<const Scene>& scene, const SessionOptions& options,
                  const IntegratorChoice& choice);
    RenderSession(std::shared_ptr<const Scene> scene, SessionOptions options, nlohmann::json parameters,
                  SlicedIntegrator::Make make);
    /// What has been rendered, by this process or by a team.
    struct Snapshot {
        const Film& film;
        const HalfSums* halves;  ///< closed; null if they are not kept
        PassReport report;
        TechniqueCounts nonFinite;
        RayStatistics rays;
        std::function<std::vector<SliceState>()> slices;
    };
    /// A run in progress.
    struct Run {
        const RunOptions& options;
        const RunHooks& hooks;
        OutputSet outputs;
        double nextSave, nextCheckpoint;
        std::string checkpointFailure;
        std::vector<FileLock> locks;
        void warn(const std::string& message) const {
            if (hooks.warn) hooks.warn(message);
        }
    };
    Run begin(const RunOptions& options, const RunHooks& hooks);
    void end(double seconds);
    Snapshot here(const PassReport& report) const;
    /// Denoising takes seconds: intermediate images go without.
    enum class Denoising { Skipped, Done };
    RenderedFrame frame(const Snapshot& now, Denoising denoising);
    const DenoisingFeatures& features();
    bool denoises() const { return halves_ != nullptr; }
    nlohmann::json statistics(const Snapshot& now, std::optional<StopReason> reason) const;
    void saveWhatIsDue(Run& run, const Snapshot& now);
    void saveCheckpoint(Run& run, const Snapshot& now);
    void conclude(Run& run, const Snapshot& end, SessionResult& result);
    Checkpoint checkpoint(const RunOptions& options, const Snapshot& now);
    void shareSlices(Team& team, const RenderLimits& limits);
    void report(Run& run, const TeamResult& all, double seconds, SessionResult& result);
    std::unique_ptr<Film> merged(const TeamResult& result) const;
    RayStatistics rays() const;
    TechniqueCounts nonFinite() const;

    std::shared_ptr<const Scene> scene_;
    SessionOptions options_;
    nlohmann::json parameters_;                            ///< of the integrator, by name
    mutable std::optional<nlohmann::json> sceneIdentity_;  ///< files are read once for it
    Film film_;
    SlicedIntegrator integrator_;
    std::shared_ptr<HalfSums> halves_;  ///< null: not denoised
    std::optional<CameraLayers> cameraLayers_;
    DenoisingFeatures features_;  ///< empty until they are needed
    std::string denoiser_;        ///< of the last denoised image
    double secondsForAovs_ = 0, secondsForFeatures_ = 0, secondsForDenoising_ = 0;
    double secondsBefore_ = 0;           ///< of the runs and processes before
    TechniqueCounts nonFiniteBefore_{};  ///< of the processes before
    RayStatistics raysBefore_, counterStart_;
    bool counting_ = false;  ///< rays are being traced: the counters since counterStart_ are this session's
    std::optional<StopReason> lastReason_;
};

}  // namespace metrolux::core
