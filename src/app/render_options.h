#pragma once
/// Options of `render`, of which other commands take parts.

#include "api/internals.h"

#include <CLI/CLI.hpp>

#include <optional>

namespace metrolux::core::app {

/// How a rendering can be watched (app/live_options.h).
struct LiveArguments {
    bool serves = false, staysClosed = false;
    std::string port, address, tev;
    bool isWanted() const { return serves || !tev.empty(); }
};

struct RenderArguments {
    std::string scene, time, error, saveEvery, memory, sceneMemory, resolution, crop, filter, sensor, stats,
        checkpointEvery, onlySlices;
    uint32_t slices = 0;  ///< 0: not divided
    std::vector<std::string> outputs, defines;
    metrolux::SessionOptions session;
    metrolux::Limits limits;
    metrolux::Files files;
    LiveArguments live;
    int rank = 0;  ///< in a team: files are written by rank 0
    std::string progress = "text";
    bool lenient = false, strict = false, quiet = false, verbose = false;
    bool denoise = false;     ///< --denoise: a layer of the session
    bool otherBuild = false;  ///< `resume`
};

/// --define, --sensor, --resolution, --crop, --filter, --scene-memory, --lenient, --strict.
void addSceneOptions(CLI::App& app, RenderArguments& a);
/// --lenient and --strict, which exclude each other.
void addStrictnessOptions(CLI::App& app, bool& lenient, bool& strict, const std::string& group);
/// -o, --stats and how images are written.
void addOutputOptions(CLI::App& app, RenderArguments& a);
/// --progress, --verbose.
void addProgressOptions(CLI::App& app, RenderArguments& a, const std::string& group);
/// --time, --passes, --error. `otherwise`: what holds without any.
void addLimitOptions(CLI::App& app, RenderArguments& a, const std::string& otherwise);
/// --checkpoint, --checkpoint-every.
void addCheckpointOptions(CLI::App& app, RenderArguments& a);
/// --slices, --only-slices.
void addSliceOptions(CLI::App& app, RenderArguments& a);
/// Everything that `render` takes.
void addRenderOptions(CLI::App& app, RenderArguments& a);
/// --integrator and everything that changes what it computes.
void addAlgorithmOptions(CLI::App& app, RenderArguments& a);
/// --threads, --memory.
void addMachineOptions(CLI::App& app, RenderArguments& a);

/// Checks the values of the algorithm's options. Warns of parameters that the integrator does not have, and
/// drops them, unless the scene names the integrator. Throws Error.
void prepareAlgorithm(RenderArguments& a);
/// The rest of it when the scene is known. Throws Error.
IntegratorChoice completeAlgorithm(RenderArguments& a, const Scene& scene);
/// What every integrator takes, on a scene with these limits.
CommonOptions commonOptions(const RenderArguments& a, const PathLimits& limits);
/// Whether the image is denoised, by any of the options that say so; after prepareOutputs().
bool denoises(const RenderArguments& a);
/// Checks what is named for output, before anything expensive begins. Throws Error.
void prepareOutputs(RenderArguments& a);
/// What a scene is called: its file's name, or its folder's if the file is `scene.xml`, as in collections.
std::string sceneName(const std::filesystem::path& scene);
/// All files that are to be written.
std::vector<NamedOutput> namedOutputs(const RenderArguments& a);
/// All of it for `render`: values and outputs, before anything expensive begins. Throws Error.
void prepareRender(RenderArguments& a);
/// The options of the scene. Throws Error.
metrolux::LoadOptions loadOptions(const RenderArguments& a);
/// Reads a scene with the options for it. Throws Error.
SceneParts loadSceneParts(const std::filesystem::path& file, const RenderArguments& a);
/// Warns of contributions that were not finite.
void reportNonFinite(const std::string& statistics);
/// Reports what became of the files; the exit status.
int conclude(const metrolux::Outcome& outcome, const std::string& statistics, const RenderArguments& a);
/// Renders; the exit status. `before`: a checkpoint to go on from. Throws Error.
int render(RenderArguments& a, std::optional<Checkpoint> before);

}  // namespace metrolux::core::app
