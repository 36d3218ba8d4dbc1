#include "app/render_options.h"

#include "app/live_options.h"
#include "app/option_parsing.h"
#include "app/parameter_options.h"
#include "app/validators.h"
#include "base/error.h"
#include "image/atomic_file.h"

#include <algorithm>

namespace metrolux::core::app {

namespace fs = std::filesystem;

void addOutputOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Output";
    app.add_option("-o,--output", a.outputs,
                   "Image to write, .exr or .png; may be given more than once (default: the scene's name\n"
                   "with .exr, or its folder's if that is scene.xml, in the current folder)")
        ->option_text("FILE")
        ->allow_extra_args(false)
        ->group(group);
    app.add_option("--exposure", a.files.display.exposure, "Exposure of PNG files in stops (default: 0)")
        ->option_text("EV")
        ->check(CLI::Range(-100.0, 100.0))
        ->group(group);
    app.add_option("--curve", a.files.display.curve,
                   "Tone curve of PNG files: srgb clips (default), filmic rolls off highlights")
        ->option_text("srgb|filmic")
        ->check(CLI::IsMember({"srgb", "filmic"}))
        ->group(group);
    app.add_option(
           "--aov", a.session.layers,
           "Layers to add to EXR files, of albedo, normal, depth, alpha, position, uv, object, material,\n"
           "motion, crypto_object, crypto_material, variance, denoised")
        ->option_text("NAME,...")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->group(group);
    app.add_flag(
           "--denoise", a.denoise,
           "Take the noise out at the end: a layer `denoised` of EXR files, beside the plain image, and\n"
           "what PNG files show (docs/reference/denoising.md)")
        ->group(group);
    app.add_option("--stats", a.stats, "JSON file for statistics")->option_text("FILE")->group(group);
    app.add_flag("--overwrite", a.files.overwrite,
                 "Replace existing images that Metrolux has not written, too")
        ->group(group);
    app.add_flag("--quiet", a.quiet, "Show errors and warnings only")->group(group);
}

void addProgressOptions(CLI::App& app, RenderArguments& a, const std::string& group) {
    app.add_option("--progress", a.progress,
                   "Progress: text (default), none, or json: an object a line on standard output, for\n"
                   "programs (docs/reference/command.md)")
        ->option_text("text|json|none")
        ->check(CLI::IsMember({"text", "json", "none"}))
        ->group(group);
    app.add_flag("-v,--verbose", a.verbose, "Show what the integrator has to say about itself, too")
        ->group(group);
}

void addLimitOptions(CLI::App& app, RenderArguments& a, const std::string& otherwise) {
    const std::string group = fmt::format("When to stop (whichever comes first; without any: {})", otherwise);
    app.add_option("--time", a.time, "Time to render for: 90s, 5m, 1h30m; loading is not counted")
        ->option_text("TIME")
        ->group(group);
    app.add_option("--passes", a.limits.passes, "Number of passes")
        ->option_text("N")
        ->check(wholeNumber<uint32_t>(1, Film::kMostPasses))
        ->group(group);
    app.add_option("--error", a.error, "Estimated relative error of the image (root mean square): 0.02 or 2%")
        ->option_text("X")
        ->group(group);
}

void addCheckpointOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Checkpoints";
    app.add_option(
           "--checkpoint", a.files.checkpoint,
           "File for the whole state of the rendering: `metrolux resume FILE` goes on from it,\nbit for "
           "bit. The last two are kept, FILE and FILE.1")
        ->option_text("FILE")
        ->group(group);
    app.add_option(
           "--checkpoint-every", a.checkpointEvery,
           fmt::format("Time between checkpoints: 90s, {}m (default), 1h; the last is written at the end",
                       kDefaultCheckpointEvery / 60))
        ->option_text("TIME")
        ->group(group);
}

void addSliceOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Many machines (docs/how-to/many-machines.md)";
    app.add_option(
           "--slices", a.slices,
           "Divide the rendering into S independent slices of passes. Under mpirun the ranks share\nthem; "
           "for given S, seed and passes the image is the same on any number of ranks")
        ->option_text("S")
        ->check(wholeNumber<uint32_t>(1, kMostSlices))
        ->group(group);
    app.add_option("--only-slices", a.onlySlices,
                   "Render these of the slices: the checkpoint is a part for `metrolux merge`")
        ->option_text("A-B")
        ->group(group);
    // Their names before 0.3.0, which scripts have.
    app.add_option("--streams", a.slices)
        ->check(wholeNumber<uint32_t>(1, kMostSlices))
        ->excludes("--slices")
        ->group("");
    app.add_option("--only-streams", a.onlySlices)->excludes("--only-slices")->group("");
}

void addRenderOptions(CLI::App& app, RenderArguments& a) {
    app.add_option("scene", a.scene, "Mitsuba scene (XML of version 3.x, 2.x, 0.6 or 0.5), glTF, or pbrt")
        ->required();
    addSceneOptions(app, a);
    addOutputOptions(app, a);
    app.add_option(
           "--save-every", a.saveEvery,
           fmt::format("Time between saves of the image so far: 90s, 5m (default: {}s; 0: only at the "
                       "end)",
                       kDefaultSaveEvery))
        ->option_text("TIME")
        ->group("Output");
    addProgressOptions(app, a, "Output");
    addServeOptions(app, a.live);
    addLimitOptions(app, a, fmt::format("--time {}s", kDefaultSeconds));
    addCheckpointOptions(app, a);
    addSliceOptions(app, a);
    addAlgorithmOptions(app, a);
    addMachineOptions(app, a);
}

void addSceneOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Scene";
    app.add_option("-D,--define", a.defines, "Value for a <default> or $parameter of the scene")
        ->option_text("NAME=VALUE")
        ->allow_extra_args(false)
        ->group(group);
    app.add_option("--resolution", a.resolution, "Size of the image in place of the scene's")
        ->option_text("WIDTHxHEIGHT")
        ->group(group);
    app.add_option("--crop", a.crop, "Render this part of the image only, in pixels")
        ->option_text("X,Y,WIDTH,HEIGHT")
        ->group(group);
    app.add_option("--filter", a.filter,
                   "Reconstruction filter in place of the scene's, with its default width:\nbox, tent, "
                   "gaussian, mitchell, catmullrom, lanczos")
        ->option_text("NAME")
        ->group(group);
    app.add_option("--scene-memory", a.sceneMemory,
                   "What the scene's data may take: 4G, 512M (default: the machine's memory)")
        ->option_text("SIZE")
        ->group(group);
    app.add_option(
           "--sensor", a.sensor,
           "Which of several sensors: its number, from 0, or its id (default: 0); `render` takes\nall: "
           "one after the other, to NAME.SENSOR.exr")
        ->option_text("N|ID|all")
        ->group(group);
    addStrictnessOptions(app, a.lenient, a.strict, group);
}

void addStrictnessOptions(CLI::App& app, bool& lenient, bool& strict, const std::string& group) {
    CLI::Option* const isLenient =
        app.add_flag("--lenient", lenient,
                     "Warn of unknown plugins and parameters instead of refusing the scene")
            ->group(group);
    app.add_flag("--strict", strict, "Refuse the scene where there would be a warning")
        ->excludes(isLenient)
        ->group(group);
}

void addAlgorithmOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Algorithm";
    app.add_option("-i,--integrator", a.session.integrator,
                   "One of `metrolux integrators`, or `scene` for what the scene names (default: " +
                       std::string(kDefaultIntegrator) + ")")
        ->option_text("NAME")
        ->group(group);
    app.add_option("--max-depth", a.session.maxDepth,
                   "Largest number of path edges; -1: no limit (default: the scene's)")
        ->option_text("N")
        ->check(wholeNumber(-1, 1 << 20))
        ->group(group);
    app.add_option("--seed", a.session.seed, "Seed of all random numbers (default: 0)")
        ->option_text("K")
        ->check(wholeNumber<uint64_t>(0, std::numeric_limits<uint64_t>::max()))
        ->group(group);
    addParameterOptions(app, a.session.parameters);
}

void addMachineOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Machine";
    app.add_option("--threads", a.session.threads, "Number of threads (default: one for each core)")
        ->option_text("T")
        ->check(wholeNumber(1, 4096))
        ->group(group);
    app.add_option(
           "--memory", a.memory,
           fmt::format("What an iteration may store: 4G, 512M (default: {}M); larger images\nare made of "
                       "more iterations a pass",
                       kDefaultMemory >> 20))
        ->option_text("SIZE")
        ->group(group);
}

void prepareAlgorithm(RenderArguments& a) {
    if (!a.memory.empty()) {
        constexpr size_t kLeast = 64 << 10;  // some hundred pixels at a time
        a.session.memory = parseMemory(a.memory);
        if (a.session.memory < kLeast)
            throw Error("--memory {}: found less than an iteration can do with, expected at least 64k",
                        a.memory);
    }
    if (a.session.integrator != kSceneIntegrator)
        settleParameters(a.session.parameters, findIntegrator(a.session.integrator));
}

IntegratorChoice completeAlgorithm(RenderArguments& a, const Scene& scene) {
    const SceneIntegrator& integrator = scene.parts().integrator;
    if (a.session.integrator == kSceneIntegrator)
        settleParameters(a.session.parameters,
                         *chooseIntegrator(a.session.integrator, integrator).integrator);
    return chooseIntegrator(a.session.integrator, integrator, a.session.parameters);
}

CommonOptions commonOptions(const RenderArguments& a, const PathLimits& limits) {
    CommonOptions options;
    options.seed = a.session.seed;
    options.memoryBytes = a.session.memory;
    options.limits = limits;
    if (a.session.maxDepth) options.limits.maxDepth = *a.session.maxDepth;
    return options;
}

bool denoises(const RenderArguments& a) {
    const std::vector<std::string>& layers = a.session.layers;
    return std::find(layers.begin(), layers.end(), kDenoisedLayer) != layers.end();
}

void prepareOutputs(RenderArguments& a) {
    if (a.denoise && !denoises(a)) a.session.layers.emplace_back(kDenoisedLayer);
    for (const std::string& name : a.session.layers) aovFromName(name);
    if (a.rank > 0) return;  // rank 0 writes
    a.files.images.assign(a.outputs.begin(), a.outputs.end());
    const OutputSet checked(a.files.images, api::displayOf(a.files.display), a.files.overwrite);
    if (!a.stats.empty()) checkWritable(a.stats);
}

namespace {

void prepareCheckpoints(RenderArguments& a) {
    metrolux::Files& files = a.files;
    if (!a.checkpointEvery.empty()) {
        if (files.checkpoint.empty())
            throw Error("--checkpoint-every {}: there is no file, name it with --checkpoint FILE",
                        a.checkpointEvery);
        files.checkpointEvery = parseDuration(a.checkpointEvery);
    }
    if (files.command.empty()) files.command = commandWords();
}

void prepareSlices(RenderArguments& a) {
    metrolux::Slices& choice = a.session.slices;
    choice.count = std::max(a.slices, uint32_t{1});
    if (a.onlySlices.empty()) return;
    const Range range = parseRange(a.onlySlices);
    if (a.slices == 0)
        throw Error("--only-slices {}: of how many is missing, say it with --slices S", a.onlySlices);
    if (range.last >= choice.count)
        throw Error("--only-slices {}: found slice {}, expected 0 to {}", a.onlySlices, range.last,
                    choice.count - 1);
    if (a.files.checkpoint.empty())
        throw Error(
            "--only-slices {}: the part for `metrolux merge` needs a file, name it with --checkpoint FILE",
            a.onlySlices);
    if (a.limits.relativeError > 0)
        throw Error("--error: a part knows the error of its own passes only; give --time or --passes");
    choice.first = range.first;
    choice.last = range.last;
}

}  // namespace

std::string sceneName(const fs::path& scene) {
    const fs::path file = fs::absolute(scene).lexically_normal();
    const std::string stem = file.stem().string();
    return stem == "scene" && file.parent_path().has_filename() ? file.parent_path().filename().string()
                                                                : stem;
}

std::vector<NamedOutput> namedOutputs(const RenderArguments& a) {
    std::vector<NamedOutput> result = api::namedOutputs(a.files);
    if (!a.stats.empty()) result.push_back({fmt::format("--stats '{}'", a.stats), a.stats});
    return result;
}

void prepareRender(RenderArguments& a) {
    if (!a.time.empty()) a.limits.seconds = parseDuration(a.time);
    if (!a.error.empty()) a.limits.relativeError = parseRelativeError(a.error);
    if (!a.saveEvery.empty()) a.files.saveEvery = parseInterval(a.saveEvery);
    prepareAlgorithm(a);
    prepareSlices(a);
    if (a.outputs.empty() && a.onlySlices.empty()) a.outputs.push_back(sceneName(a.scene) + ".exr");
    prepareOutputs(a);
    prepareCheckpoints(a);
}

metrolux::LoadOptions loadOptions(const RenderArguments& a) {
    metrolux::LoadOptions options;
    options.defines = parseDefines(a.defines);
    options.lenient = a.lenient;
    options.strict = a.strict;
    options.sensor = a.sensor;
    options.threads = a.session.threads;
    if (!a.filter.empty()) options.film.filter = a.filter;
    if (!a.sceneMemory.empty()) options.memory = parseMemory(a.sceneMemory);
    if (!a.resolution.empty()) options.film.resolution = parseResolution(a.resolution);
    if (!a.crop.empty()) options.film.crop = parseCrop(a.crop);
    return options;
}

SceneParts loadSceneParts(const fs::path& file, const RenderArguments& a) {
    const LoadOptions options = api::coreOptions(loadOptions(a));
    SceneParts parts = loadScene(file, options);
    api::settle(parts, options);
    return parts;
}

}  // namespace metrolux::core::app
