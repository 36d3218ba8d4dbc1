#include "app/commands.h"
#include "app/interrupt.h"
#include "app/option_parsing.h"
#include "app/render_options.h"
#include "app/validators.h"
#include "base/error.h"
#include "image/atomic_file.h"
#include "render/threads.h"
#include "study/machine.h"
#include "study/page.h"
#include "study/report.h"

#include <metrolux/version.h>

#include <spdlog/spdlog.h>

#include <set>

namespace metrolux::core::app {
namespace {

namespace fs = std::filesystem;
using study::Entrant;
using study::Plan;

constexpr const char* kStudyExamples = R"(Examples:
  metrolux study scene.xml --integrators path,vcm,mcmc_vcm --time 60s --ref reference.exr
  metrolux study a.xml b.xml --integrators path,mcmc_vcm --time 5m --ref-time 1h -o results
  metrolux study scene.xml --integrators mcmc_vcm,mcmc_vcm:kernel=adaptive --passes 64 --seeds 8 --ref reference.exr

An integrator may be followed by options of `metrolux render` that are for it alone, as in
mcmc_vcm:kernel=adaptive:chain-inefficiency=8.

All integrators render with the first seed, one after the other on all threads, then all with the next one. Their
error is measured at times that grow by the square root of 2; measuring stops the clock. The machine should be quiet
(or --clock cpu).

Each scene gets a folder: index.html (a page that needs no network: images side by side, curves, table),
study.json, curves.csv, table.md, and the images as EXR and PNG. docs/reference/study.md defines all numbers.

Ctrl-C ends the pass in progress, writes what is there and exits with status 3.)";

struct StudyArguments {
    RenderArguments render;  ///< scene and machine options
    std::vector<std::string> scenes, integrators, references;
    std::string time, referenceTime, referenceIntegrator = kDefaultIntegrator, folder = "study",
                                     clock = "wall";
    Plan plan;
};

void addComparisonOptions(CLI::App& app, StudyArguments& a) {
    const char* const group = "Comparison";
    app.add_option("--integrators", a.integrators,
                   "What to compare: names of `metrolux integrators`, each may have options:\n"
                   "NAME:option=value:flag")
        ->option_text("NAME,...")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->required()
        ->group(group);
    app.add_option("--time", a.time, "Equal time for each run: 90s, 5m, 1h30m (default: 60s)")
        ->option_text("TIME")
        ->group(group);
    app.add_option(
           "--clock", a.clock,
           "What --time counts: `wall` (default), or `cpu`, processor time over threads, for a machine\nthat "
           "is shared")
        ->option_text("NAME")
        ->check(CLI::IsMember({"wall", "cpu"}))
        ->group(group);
    app.add_option("--passes", a.plan.passes, "Equal number of passes in place of equal time")
        ->option_text("N")
        ->check(wholeNumber<uint32_t>(1, Film::kMostPasses))
        ->group(group);
    app.add_option("--seeds", a.plan.seeds,
                   "Runs of each integrator (default: 3); with 1 there are no confidence bands")
        ->option_text("K")
        ->check(wholeNumber(1, 1000))
        ->group(group);
    app.add_option("--seed", a.plan.firstSeed, "First seed, the others follow it (default: 1)")
        ->option_text("S")
        ->check(wholeNumber<uint64_t>(0, uint64_t{1} << 62))
        ->group(group);
    app.add_option("--max-depth", a.render.session.maxDepth,
                   "Largest number of path edges; -1: no limit (default: the scene's)")
        ->option_text("N")
        ->check(wholeNumber(-1, 1 << 20))
        ->group(group);
    app.add_option("--epsilon", a.plan.epsilon, "Epsilon of relMSE (default: 0.01)")
        ->option_text("E")
        ->check(realNumber(false))
        ->group(group);
}

void addReferenceOptions(CLI::App& app, StudyArguments& a) {
    const char* const group = "Reference (one of --ref and --ref-time)";
    app.add_option("--ref", a.references,
                   "Reference image of a scene's size; once for each scene, in their order")
        ->option_text("FILE")
        ->allow_extra_args(false)
        ->group(group);
    app.add_option("--ref-time", a.referenceTime,
                   "Render a reference for each scene for this time, as two independent halves\n"
                   "that tell its noise")
        ->option_text("TIME")
        ->group(group);
    app.add_option("--ref-integrator", a.referenceIntegrator,
                   "Integrator of --ref-time, may have options (default: mcmc_vcm)")
        ->option_text("NAME")
        ->group(group);
}

/// An integrator with options: "mcmc_vcm:kernel=adaptive". They are read as those of `metrolux render`.
Entrant parseEntrant(const std::string& text, const RenderArguments& common) {
    std::vector<std::string> words;
    size_t end = text.find(':');
    const std::string integrator = text.substr(0, end);
    while (end != std::string::npos) {
        const size_t begin = end + 1;
        end = text.find(':', begin);
        const std::string setting = text.substr(begin, end == std::string::npos ? end : end - begin);
        const std::string name = setting.substr(0, setting.find('='));
        if (name.empty()) throw Error("'{}': an option is missing after ':'", text);
        if (name == "seed" || name == "integrator")
            throw Error("'{}': '{}' cannot be an option of one integrator of a study", text, name);
        words.push_back("--" + setting);
    }
    RenderArguments a;
    a.memory = common.memory;
    a.session.maxDepth = common.session.maxDepth;
    CLI::App app;
    app.set_help_flag();
    addAlgorithmOptions(app, a);
    try {
        app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::ParseError& error) {
        throw Error("'{}': {}; `metrolux render --help` lists the options of algorithms", text, error.what());
    }
    a.session.integrator = integrator;
    prepareAlgorithm(a);
    return {text, integrator, a.session.parameters, commonOptions(a, {}), a.session.maxDepth, words};
}

void completePlan(StudyArguments& a) {
    if (!a.time.empty() && a.plan.passes > 0)
        throw Error(
            "--time and --passes exclude each other: a study compares at equal time or at equal passes");
    if (a.plan.passes == 0) a.plan.seconds = a.time.empty() ? 60 : parseDuration(a.time);
    std::set<std::string> files;
    for (const std::string& text : a.integrators) {
        a.plan.entrants.push_back(parseEntrant(text, a.render));
        if (!files.insert(study::runFiles(a.plan.entrants.back(), 0).exr).second)
            throw Error("--integrators: '{}' is named twice", text);
    }
}

void checkReferenceOptions(const StudyArguments& a) {
    if (a.references.empty() && a.referenceTime.empty())
        throw Error(
            "a study needs references: give --ref FILE for each scene, or --ref-time TIME to render them");
    if (!a.references.empty() && !a.referenceTime.empty())
        throw Error("--ref and --ref-time exclude each other");
    if (!a.references.empty() && a.references.size() != a.scenes.size())
        throw Error("--ref was given {} times for {} scenes: expected one for each, in their order",
                    a.references.size(), a.scenes.size());
}

/// A scene's folder is named as its file, or as the folder of a file named "scene".
std::vector<std::string> folderNames(const std::vector<std::string>& scenes) {
    std::vector<std::string> names;
    for (const std::string& scene : scenes) {
        const std::string base = sceneName(scene);
        std::string name = base;
        for (int i = 2; std::find(names.begin(), names.end(), name) != names.end(); ++i)
            name = fmt::format("{}-{}", base, i);
        names.push_back(name);
    }
    return names;
}

void checkReferenceSize(const std::string& scene, const FilmWindow& window, const std::string& file,
                        const ImageData& image) {
    if (image.width == window.width && image.height == window.height) return;
    throw Error("reference {} has {}x{} pixels, {} has {}x{}", file, image.width, image.height, scene,
                window.width, window.height);
}

nlohmann::json sceneOptions(const RenderArguments& a) {
    nlohmann::json options = nlohmann::json::object();
    if (!a.resolution.empty()) options["resolution"] = a.resolution;
    if (!a.crop.empty()) options["crop"] = a.crop;
    if (!a.filter.empty()) options["filter"] = a.filter;
    if (!a.defines.empty()) options["define"] = a.defines;
    if (a.session.maxDepth) options["max-depth"] = *a.session.maxDepth;
    return options;
}

/// Runs the scenes one after the other and knows what went wrong with their files.
class StudyRunner {
  public:
    StudyRunner(StudyArguments& arguments, int threads)
        : a_(arguments),
          names_(folderNames(arguments.scenes)),
          provenance_{metrolux::version(), commandWords(), study::describeMachine(threads),
                      sceneOptions(arguments.render)} {}

    /// Finds what cannot be used before anything is rendered. Throws Error.
    void check() const {
        if (!a_.referenceTime.empty()) parseDuration(a_.referenceTime);
        parseEntrant(a_.referenceIntegrator, a_.render);
        std::vector<ImageData> references;
        for (const std::string& file : a_.references) references.push_back(readImage(file, false));
        for (size_t i = 0; i < a_.scenes.size(); ++i) {
            const FilmWindow window = loadSceneParts(a_.scenes[i], a_.render).camera->window();
            if (!references.empty())
                checkReferenceSize(a_.scenes[i], window, a_.references[i], references[i]);
            makeFolder(folder(i));
            checkWritable(folder(i) / "study.json");
        }
    }

    int run() {
        bool interrupted = false;
        for (size_t i = 0; i < a_.scenes.size() && !interrupted; ++i) interrupted = !runScene(i);
        if (lost_) return kOutputLost;
        if (interrupted) return kInterrupted;
        if (!rendered_) throw Error("no integrator of the study can render any of its scenes");
        return kDone;
    }

  private:
    fs::path folder(size_t i) const { return fs::path(a_.folder) / names_[i]; }

    static void makeFolder(const fs::path& path) {
        std::error_code code;
        fs::create_directories(path, code);
        if (!fs::is_directory(path))
            throw Error("cannot make the folder '{}': {}", path.string(), code.message());
    }

    template <class Body>
    void writing(Body&& body) {
        try {
            body();
        } catch (const std::exception& error) {
            spdlog::error("{}", error.what());
            lost_ = true;
        }
    }

    study::Surroundings surroundings(size_t i) {
        study::Surroundings s;
        s.interrupted = interruptRequested;
        // On a log, a line after each run is enough.
        s.progress = ProgressReporter::modeFor(stderr, a_.render.quiet);
        if (s.progress == ProgressReporter::Mode::Log) s.progress = ProgressReporter::Mode::Silent;
        s.afterRun = [this, i](const study::SceneStudy& study, size_t entrant) {
            const auto& run = study.contributions[entrant].runs.back();
            writing([&] { study::writeRun(study, a_.plan, entrant, run, provenance_, folder(i)); });
            if (entrant + 1 == a_.plan.entrants.size() || study.interrupted) writeReport(study, i);
        };
        return s;
    }

    void writeReport(const study::SceneStudy& study, size_t i) {
        writing([&] { study::writeReport(study, a_.plan, provenance_, folder(i)); });
    }

    std::optional<study::Reference> reference(const Scene& scene, size_t i) {
        if (a_.referenceTime.empty()) {
            study::Reference result;
            result.file = a_.references[i];
            result.image = readImage(result.file, false);
            checkReferenceSize(a_.scenes[i], scene.camera().window(), result.file, result.image);
            return result;
        }
        spdlog::info("rendering the reference with {} for {}", a_.referenceIntegrator, a_.referenceTime);
        return study::renderReference(scene, a_.plan, parseEntrant(a_.referenceIntegrator, a_.render),
                                      parseDuration(a_.referenceTime), surroundings(i));
    }

    /// False when it was interrupted.
    bool runScene(size_t i) {
        SceneParts parts = loadSceneParts(a_.scenes[i], a_.render);
        study::SceneStudy study{names_[i], a_.scenes[i], parts.camera->window(), parts.warnings, {},
                                {},        false};
        for (const std::string& warning : parts.warnings) spdlog::warn("{}", warning);
        const Scene scene(std::move(parts));
        spdlog::info("{}: {}x{} pixels, {} integrators, {} seeds", study.file, study.window.width,
                     study.window.height, a_.plan.entrants.size(), a_.plan.seeds);
        auto found = reference(scene, i);
        if (!found) {
            spdlog::warn("{}: interrupted before there was a reference: nothing was written", study.file);
            return false;
        }
        study.reference = std::move(*found);
        warnOfReference(study.reference);
        writing([&] { study::writeReference(study, provenance_, folder(i)); });
        study::runStudy(scene, a_.plan, study, surroundings(i));
        conclude(study, i);
        return !study.interrupted;
    }

    static void warnOfReference(const study::Reference& reference) {
        const size_t bad = compareImages(reference.image, reference.image).nonFinite;
        if (bad > 0) spdlog::warn("{} pixels of the reference are not finite and are left out", bad);
        if (reference.noise)
            spdlog::info("the reference's own noise: relMSE {:.3g}", reference.noise->relMse);
    }

    void conclude(const study::SceneStudy& study, size_t i) {
        writeReport(study, i);
        for (const study::Contribution& contribution : study.contributions)
            rendered_ = rendered_ || !contribution.runs.empty();
        if (!a_.render.quiet) fmt::print("{}\n", study::markdownTable(study, a_.plan));
        spdlog::info("wrote {}", (folder(i) / "index.html").string());
    }

    StudyArguments& a_;
    std::vector<std::string> names_;
    study::Provenance provenance_;
    bool lost_ = false, rendered_ = false;
};

int runStudyCommand(StudyArguments& a) {
    if (a.render.quiet) spdlog::set_level(spdlog::level::warn);
    checkReferenceOptions(a);
    completePlan(a);
    catchInterrupts();
    ThreadLimit limit(a.render.session.threads);
    a.plan.threads = limit.threads();
    a.plan.clock = a.clock == "cpu" ? study::Clock::Processor : study::Clock::Wall;
    return limit.execute([&] {
        StudyRunner runner(a, limit.threads());
        runner.check();
        return runner.run();
    });
}

}  // namespace

Run addStudyCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("study", "Compare integrators at equal time or equal passes");
    app->footer(kStudyExamples);
    auto arguments = std::make_shared<StudyArguments>();
    app->add_option("scene", arguments->scenes, "Mitsuba scenes")->required()->option_text("SCENE...");
    addComparisonOptions(*app, *arguments);
    addReferenceOptions(*app, *arguments);
    app->add_option("-o,--output", arguments->folder, "Folder to write to (default: study)")
        ->option_text("FOLDER")
        ->group("Output");
    app->add_flag("--quiet", arguments->render.quiet, "Show errors and warnings only")->group("Output");
    addSceneOptions(*app, arguments->render);
    addMachineOptions(*app, arguments->render);
    return [arguments] { return runStudyCommand(*arguments); };
}

}  // namespace metrolux::core::app
