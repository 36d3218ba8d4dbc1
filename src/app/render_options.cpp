#include "app/render_options.h"

#include "app/option_parsing.h"
#include "app/validators.h"
#include "base/error.h"
#include "base/suggest.h"
#include "image/atomic_file.h"

#include <spdlog/spdlog.h>

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
    app.add_option("--exposure", a.session.display.exposure, "Exposure of PNG files in stops (default: 0)")
        ->option_text("EV")
        ->check(CLI::Range(-100.0, 100.0))
        ->group(group);
    app.add_option("--curve", a.curve,
                   "Tone curve of PNG files: srgb clips (default), filmic rolls off highlights")
        ->option_text("srgb|filmic")
        ->check(CLI::IsMember({"srgb", "filmic"}))
        ->group(group);
    app.add_option("--aov", a.aovs, "Layers to add to EXR files, of albedo, normal, depth, variance")
        ->option_text("NAME,...")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->group(group);
    app.add_option("--stats", a.stats, "JSON file for statistics")->option_text("FILE")->group(group);
    app.add_flag("--overwrite", a.session.overwrite,
                 "Replace existing images that Metrolux has not written, too")
        ->group(group);
    app.add_flag("--quiet", a.quiet, "Show errors and warnings only")->group(group);
}

void addLimitOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "When to stop (whichever comes first; without any: --time 60s)";
    app.add_option("--time", a.time, "Time to render for: 90s, 5m, 1h30m; loading is not counted")
        ->option_text("TIME")
        ->group(group);
    app.add_option("--passes", a.session.limits.passes, "Number of passes")
        ->option_text("N")
        ->check(wholeNumber<uint32_t>(1, std::numeric_limits<uint32_t>::max()))
        ->group(group);
    app.add_option("--error", a.error, "Estimated relative error of the image (root mean square): 0.02 or 2%")
        ->option_text("X")
        ->group(group);
}

void addCheckpointOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Checkpoints";
    app.add_option(
           "--checkpoint", a.session.checkpoint.file,
           "File for the whole state of the rendering: `metrolux resume FILE` goes on from it,\nbit for "
           "bit. The last two are kept, FILE and FILE.1")
        ->option_text("FILE")
        ->group(group);
    app.add_option("--checkpoint-every", a.checkpointEvery,
                   "Time between checkpoints: 90s, 5m (default), 1h; the last is written at the end")
        ->option_text("TIME")
        ->group(group);
}

void addStreamOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Many machines (docs/how-to/many-machines.md)";
    app.add_option(
           "--streams", a.streams,
           "Divide the rendering into S independent streams of passes. Under mpirun the ranks share\nthem; "
           "for given S, seed and passes the image is the same on any number of ranks")
        ->option_text("S")
        ->check(wholeNumber<uint32_t>(1, kMostStreams))
        ->group(group);
    app.add_option("--only-streams", a.onlyStreams,
                   "Render these of the streams: the checkpoint is a part for `metrolux merge`")
        ->option_text("A-B")
        ->group(group);
}

void addRenderOptions(CLI::App& app, RenderArguments& a) {
    app.add_option("scene", a.scene, "Mitsuba scene: XML of version 3.x, 2.x, 0.6 or 0.5")->required();
    addSceneOptions(app, a);
    addOutputOptions(app, a);
    app.add_option("--save-every", a.saveEvery,
                   "Time between saves of the image so far: 90s, 5m (default: 60s; 0: only at the end)")
        ->option_text("TIME")
        ->group("Output");
    addLimitOptions(app, a);
    addCheckpointOptions(app, a);
    addStreamOptions(app, a);
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
    app.add_option("--sensor", a.sensor,
                   "Which of several sensors: its number, from 0, or its id (default: 0)")
        ->option_text("N|ID")
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
    IntegratorOptions& integrator = a.session.integratorOptions;
    app.add_option("-i,--integrator", a.session.integrator,
                   "One of `metrolux integrators`, or `scene` for what the scene names (default: mcmc_vcm)")
        ->option_text("NAME")
        ->group(group);
    app.add_option("--max-depth", a.maxDepth,
                   "Largest number of path edges; -1: no limit (default: the scene's)")
        ->option_text("N")
        ->check(wholeNumber(-1, 1 << 20))
        ->group(group);
    app.add_option("--seed", integrator.seed, "Seed of all random numbers (default: 0)")
        ->option_text("K")
        ->check(wholeNumber<uint64_t>(0, std::numeric_limits<uint64_t>::max()))
        ->group(group);
    app.add_option("--radius", integrator.radius,
                   "First merging radius in scene units (default: from the pixel size)")
        ->option_text("R")
        ->check(realNumber(false))
        ->group(group);
    app.add_option("--replicas", integrator.replicas,
                   "mcmc_vcm, vpt, split_mcmc: chains that take part, of u (uniform), v (visibility)\nand f "
                   "(contribution, mcmc_vcm only) (default: all)")
        ->option_text("uvf")
        ->group(group);
    app.add_option(
           "--kernel", a.kernel,
           "Mutation of chains: `kelemen` (default) or `adaptive` (the paper's, larger steps;\ndefault of "
           "vpt and split_mcmc)")
        ->option_text("NAME")
        ->check(CLI::IsMember({"kelemen", "adaptive"}))
        ->group(group);
    app.add_option("--large-step", integrator.largeStep,
                   "pssmlt, mmlt, pssmlt_merge: probability of a step to a uniform sample (default: 0.3)")
        ->option_text("P")
        ->check(CLI::Range(0.0, 1.0))
        ->group(group);
    app.add_option("--method", a.method,
                   "pssmlt_merge: light subpaths for merging from a visibility chain (B, default)\nor from "
                   "pssmlt's own states (A, experimental: biased)")
        ->option_text("B|A")
        ->check(CLI::IsMember({"A", "B"}))
        ->group(group);
    app.add_option("--chain-inefficiency", integrator.chainInefficiency,
                   "mcmc_vcm, vpt, split_mcmc: steps of a chain that count as one independent sample in the "
                   "weights (default: "
                   "4); changes noise, not brightness")
        ->option_text("G")
        ->check(CLI::Range(1.0, 1e6))
        ->group(group);
    app.add_option("--connections", integrator.connections,
                   "bdpt, vcm, mcmc_vcm: share of the light subpaths that are connected with an eye subpath\n"
                   "(default: 1; mcmc_vcm: 0.0625); changes noise, not brightness")
        ->option_text("C")
        ->check(CLI::Range(1e-6, 1.0))
        ->group(group);
    app.add_option("--split", a.split,
                   "mcmc_vcm, vpt, split_mcmc: parts of the replicas u/v/f in the samples (default: 1/1/1);\n"
                   "`auto` (mcmc_vcm): by the noise that each replica makes")
        ->option_text("U/V/F")
        ->group(group);
    app.add_option(
           "--target", a.target,
           "mcmc_vcm: what chains of f look for: `luminance` (default), or `relative` to what the\nimage "
           "shows there so far")
        ->option_text("NAME")
        ->check(CLI::IsMember({"luminance", "relative"}))
        ->group(group);
    app.add_option(
           "--normalization", a.normalization,
           "mcmc_vcm: of f, from independent and visibility samples (`pooled`, default) or from all\nby "
           "`bennett`'s ratio; changes noise, not brightness")
        ->option_text("NAME")
        ->check(CLI::IsMember({"pooled", "bennett"}))
        ->group(group);
    app.add_option("--theta", a.theta,
                   "mcmc_vcm, vpt, split_mcmc: adaptive kernel steered for each `lane` (default) or `pooled`")
        ->option_text("NAME")
        ->check(CLI::IsMember({"lane", "pooled"}))
        ->group(group);
    app.add_flag(
           "!--no-correlation-aware", integrator.correlationAware,
           "vcm, mcmc_vcm, split_mcmc: weigh merges that share an eye vertex as if they were independent")
        ->group(group);
    app.add_option("--lanes", integrator.lanes, "Number of independent sets of chains")
        ->option_text("N")
        ->check(wholeNumber(1, 1 << 20))
        ->group(group);
}

void addMachineOptions(CLI::App& app, RenderArguments& a) {
    const char* const group = "Machine";
    app.add_option("--threads", a.threads, "Number of threads (default: one for each core)")
        ->option_text("T")
        ->check(wholeNumber(1, 4096))
        ->group(group);
    app.add_option("--memory", a.memory,
                   "What an iteration may store: 4G, 512M (default: 1408M); larger images\nare made of more "
                   "iterations a pass")
        ->option_text("SIZE")
        ->group(group);
}

namespace {

/// A fixed number, because the image depends on it: more memory of the machine must not change it. Keeps
/// 1920x1080 pixels of eight vertices each below 2.5 GB in all.
constexpr size_t kDefaultMemory = size_t{1408} << 20;

void checkReplicas(const std::string& replicas) {
    if (replicas.empty() || replicas.find_first_not_of("uvf") != std::string::npos)
        throw Error("--replicas {}: expected some of the letters u, v and f", replicas);
}

std::array<double, 3> parseSplit(const std::string& text) {
    std::array<double, 3> parts{};
    std::istringstream in(text);
    char slash1 = 0, slash2 = 0;
    in >> parts[0] >> slash1 >> parts[1] >> slash2 >> parts[2];
    const bool positive = std::all_of(parts.begin(), parts.end(), [](double p) { return p > 0 && p <= 1e6; });
    if (!in || slash1 != '/' || slash2 != '/' || in.peek() != EOF || !positive)
        throw Error(
            "--split {}: expected `auto` or three numbers above 0, such as 1/1/2 (--replicas leaves one out)",
            text);
    return parts;
}

void checkIntegratorName(const std::string& name) {
    if (name == "scene") return;
    std::vector<std::string> names;
    for (const auto& [known, description] : integratorList()) names.push_back(known);
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    const std::string nearest = nearestName(name, names);
    throw Error("unknown integrator '{}'{}; `metrolux integrators` lists them", name,
                nearest.empty() ? "" : ", did you mean '" + nearest + "'?");
}

}  // namespace

void warnOfUnusedOptions(const RenderArguments& a, const std::string& integrator) {
    const IntegratorOptions& o = a.session.integratorOptions;
    const IntegratorOptions unset;
    const std::string chains = "mcmc_vcm vpt split_mcmc", metropolis = "pssmlt mmlt pssmlt_merge";
    const struct {
        const char* option;
        bool given;
        std::string integrators;
    } uses[] = {
        {"--radius", o.radius > 0, "vcm sppm pssmlt_merge " + chains},
        {"--replicas", o.replicas.has_value(), chains},
        {"--kernel", o.kernel.has_value(), chains + " " + metropolis},
        {"--large-step", o.largeStep != unset.largeStep, metropolis},
        {"--method", o.mergeMethod != unset.mergeMethod, "pssmlt_merge"},
        {"--chain-inefficiency", o.chainInefficiency != unset.chainInefficiency, chains},
        {"--connections", o.connections.has_value(), "bdpt vcm mcmc_vcm"},
        {"--split", !a.split.empty(), chains},
        {"--target", o.target != unset.target, "mcmc_vcm"},
        {"--normalization", o.normalization != unset.normalization, "mcmc_vcm"},
        {"--theta", o.pooledTheta, chains},
        {"--no-correlation-aware", !o.correlationAware, "vcm mcmc_vcm split_mcmc"},
        {"--lanes", o.lanes > 0, chains + " " + metropolis},
    };
    for (const auto& use : uses)
        if (use.given && (" " + use.integrators + " ").find(" " + integrator + " ") == std::string::npos)
            spdlog::warn("{} has no effect on {}: it is for {}", use.option, integrator, use.integrators);
}

void prepareAlgorithm(RenderArguments& a) {
    IntegratorOptions& options = a.session.integratorOptions;
    options.memoryBytes = a.memory.empty() ? kDefaultMemory : parseMemory(a.memory);
    if (options.replicas) checkReplicas(*options.replicas);
    if (!a.kernel.empty())
        options.kernel =
            a.kernel == "adaptive" ? MutationKernel::Kind::Adaptive : MutationKernel::Kind::Kelemen;
    options.mergeMethod = a.method.front();
    if (a.split == "auto")
        options.measuredSplit = true;
    else if (!a.split.empty())
        options.split = parseSplit(a.split);
    if (a.target == "relative") options.target = ChainTarget::Relative;
    if (a.normalization == "bennett") options.normalization = NormalizationMethod::Bennett;
    options.pooledTheta = a.theta == "pooled";
    checkIntegratorName(a.session.integrator);
    if (a.session.integrator != "scene") warnOfUnusedOptions(a, a.session.integrator);
}

void prepareOutputs(RenderArguments& a) {
    SessionOptions& session = a.session;
    session.display.curve = toneCurveFromName(a.curve).value();
    for (const std::string& name : a.aovs) session.aovs.push_back(aovFromName(name));
    if (session.rank > 0) return;  // rank 0 writes
    session.outputs.assign(a.outputs.begin(), a.outputs.end());
    const OutputSet checked(session.outputs, session.display, session.overwrite);
    if (!a.stats.empty()) checkWritable(a.stats);
}

namespace {

void prepareCheckpoints(RenderArguments& a) {
    CheckpointOptions& checkpoint = a.session.checkpoint;
    if (!a.checkpointEvery.empty()) {
        if (checkpoint.file.empty())
            throw Error("--checkpoint-every {}: there is no file, name it with --checkpoint FILE",
                        a.checkpointEvery);
        checkpoint.every = parseDuration(a.checkpointEvery);
    }
    if (checkpoint.command.empty()) checkpoint.command = commandWords();
    checkpoint.folder = fs::current_path().string();
}

void prepareStreams(RenderArguments& a) {
    StreamChoice& choice = a.session.streams;
    choice.count = std::max(a.streams, uint32_t{1});
    choice.last = choice.count - 1;
    if (a.onlyStreams.empty()) return;
    const Range range = parseRange(a.onlyStreams);
    if (a.streams == 0)
        throw Error("--only-streams {}: of how many is missing, say it with --streams S", a.onlyStreams);
    if (range.last >= choice.count)
        throw Error("--only-streams {}: found stream {}, expected 0 to {}", a.onlyStreams, range.last,
                    choice.count - 1);
    if (a.session.checkpoint.file.empty())
        throw Error(
            "--only-streams {}: the part for `metrolux merge` needs a file, name it with --checkpoint FILE",
            a.onlyStreams);
    if (a.session.limits.relativeError > 0)
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
    std::vector<NamedOutput> result;
    for (const std::string& file : a.outputs) result.push_back({fmt::format("output '{}'", file), file});
    if (!a.stats.empty()) result.push_back({fmt::format("--stats '{}'", a.stats), a.stats});
    const fs::path& checkpoint = a.session.checkpoint.file;
    if (checkpoint.empty()) return result;
    result.push_back({fmt::format("--checkpoint '{}'", checkpoint.string()), checkpoint});
    const fs::path previous = previousCheckpoint(checkpoint);
    result.push_back({fmt::format("the checkpoint before the last, '{}',", previous.string()), previous});
    return result;
}

void prepareRender(RenderArguments& a) {
    SessionOptions& session = a.session;
    session.version = METROLUX_VERSION;
    if (!a.time.empty()) session.limits.seconds = parseDuration(a.time);
    if (!a.error.empty()) session.limits.relativeError = parseRelativeError(a.error);
    if (!a.saveEvery.empty()) session.saveEvery = parseInterval(a.saveEvery);
    if (!session.limits.any()) session.limits.seconds = 60;
    prepareAlgorithm(a);
    prepareStreams(a);
    if (a.outputs.empty() && a.onlyStreams.empty()) a.outputs.push_back(sceneName(a.scene) + ".exr");
    prepareOutputs(a);
    prepareCheckpoints(a);
}

namespace {

LoadOptions loadOptions(const RenderArguments& a) {
    LoadOptions options;
    options.defines = parseDefines(a.defines);
    options.lenient = a.lenient;
    options.strict = a.strict;
    options.sensor = a.sensor;
    if (!a.sceneMemory.empty()) options.memoryBytes = parseMemory(a.sceneMemory);
    if (!a.resolution.empty()) {
        const Size size = parseResolution(a.resolution);
        options.width = size.width;
        options.height = size.height;
    }
    if (!a.crop.empty()) {
        const Rectangle crop = parseCrop(a.crop);
        options.hasCrop = true;
        options.cropX = crop.x;
        options.cropY = crop.y;
        options.cropWidth = crop.width;
        options.cropHeight = crop.height;
    }
    return options;
}

}  // namespace

SceneParts loadSceneParts(const fs::path& file, const RenderArguments& a, std::vector<fs::path>* files) {
    SceneParts parts = loadScene(file, loadOptions(a), files);
    if (!a.filter.empty()) {
        parts.filterKind = filterKind(a.filter);
        parts.filter = {};
    }
    return parts;
}

}  // namespace metrolux::core::app
