#pragma once
/// Options of `render`, of which other commands take parts.

#include "io/scene_loader.h"
#include "render/session.h"

#include <CLI/CLI.hpp>

#include <optional>

namespace metrolux::core::app {

struct RenderArguments {
    std::string scene, time, error, saveEvery, memory, sceneMemory, resolution, crop, stats, filter, kernel,
        split, sensor;
    std::string curve = "srgb", method = "B", target = "luminance", normalization = "pooled", theta = "lane";
    std::string checkpointEvery, onlyStreams;
    uint32_t streams = 0;  ///< 0: not divided
    std::vector<std::string> outputs, defines, aovs;
    SessionOptions session;
    int threads = 0;
    std::optional<int> maxDepth;  ///< in place of the scene's
    bool lenient = false, strict = false, quiet = false;
};

/// --define, --sensor, --resolution, --crop, --filter, --scene-memory, --lenient, --strict.
void addSceneOptions(CLI::App& app, RenderArguments& a);
/// --lenient and --strict, which exclude each other.
void addStrictnessOptions(CLI::App& app, bool& lenient, bool& strict, const std::string& group);
/// -o, --stats and how images are written.
void addOutputOptions(CLI::App& app, RenderArguments& a);
/// --time, --passes, --error.
void addLimitOptions(CLI::App& app, RenderArguments& a);
/// --checkpoint, --checkpoint-every.
void addCheckpointOptions(CLI::App& app, RenderArguments& a);
/// --streams, --only-streams.
void addStreamOptions(CLI::App& app, RenderArguments& a);
/// Everything that `render` takes.
void addRenderOptions(CLI::App& app, RenderArguments& a);
/// --integrator and everything that changes what it computes.
void addAlgorithmOptions(CLI::App& app, RenderArguments& a);
/// --threads, --memory.
void addMachineOptions(CLI::App& app, RenderArguments& a);

/// Checks the values of the algorithm's options and completes session.integratorOptions, but for the path
/// limits, which need the scene. Throws Error.
void prepareAlgorithm(RenderArguments& a);
/// Warns of options of the algorithm that this integrator does not know (values that are the default's do no
/// harm). prepareAlgorithm() does, unless the scene names the integrator.
void warnOfUnusedOptions(const RenderArguments& a, const std::string& integrator);
/// Checks what is named for output, before anything expensive begins. Throws Error.
void prepareOutputs(RenderArguments& a);
/// What a scene is called: its file's name, or its folder's if the file is `scene.xml`, as in collections.
std::string sceneName(const std::filesystem::path& scene);
/// All files that are to be written.
std::vector<NamedOutput> namedOutputs(const RenderArguments& a);
/// All of it for `render`: values and outputs, before anything expensive begins. Throws Error.
void prepareRender(RenderArguments& a);
/// Reads a scene with the options for it. Throws Error.
SceneParts loadSceneParts(const std::filesystem::path& file, const RenderArguments& a,
                          std::vector<std::filesystem::path>* files = nullptr);
/// Warns of contributions that were not finite.
void reportNonFinite(const nlohmann::json& counts);
/// Reports what became of the files; the exit status.
int conclude(const SessionResult& result, const RenderArguments& a);
/// Renders; the exit status. `before`: a checkpoint to go on from. Throws Error.
int render(RenderArguments& a, std::optional<Checkpoint> before);

}  // namespace metrolux::core::app
