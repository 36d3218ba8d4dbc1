#include "app/commands.h"
#include "app/render_options.h"
#include "app/validators.h"
#include "base/clock.h"
#include "base/error.h"
#include "image/atomic_file.h"
#include "render/threads.h"
#include "study/machine.h"
#include "study/speed.h"

#include <spdlog/spdlog.h>

namespace metrolux::core::app {
namespace {

constexpr const char* kBenchExamples = R"(Examples:
  metrolux bench scene.xml
  metrolux bench scene.xml -i path --resolution 512x512 --threads 2 --json path.json

Renders passes with all threads and with one in turn, and traces the rays of each pass again with nothing around
them: the ray efficiency is the time of that over the time of the pass. docs/reference/bench.md explains all numbers.)";

struct BenchArguments {
    RenderArguments render;
    study::SpeedOptions speed;
    std::string json;
};

int bench(BenchArguments& a) {
    RenderArguments& r = a.render;
    prepareAlgorithm(r);
    if (!a.json.empty()) checkWritable(a.json);
    a.speed.threads = ThreadLimit(r.session.threads).threads();
    const double start = steadySeconds();
    SceneParts parts = loadSceneParts(r.scene, r);
    for (const std::string& warning : parts.warnings) spdlog::warn("{}", warning);
    const double read = steadySeconds() - start;
    const Scene scene(std::move(parts));
    const double build = steadySeconds() - start - read;

    a.speed.choice = completeAlgorithm(r, scene);
    a.speed.options = commonOptions(r, scene.parts().limits);

    nlohmann::json j{{"format", "metrolux-bench"},
                     {"scene", r.scene},
                     {"machine", study::describeMachine(a.speed.threads)},
                     {"load_seconds", {{"read", read}, {"build", build}}},
                     {"time", study::timestamp()}};
    j["passes"] = study::measurePasses(scene, a.speed);
    j["techniques"] = study::measureTechniques(scene, a.speed);
    if (!a.json.empty()) writeFile(a.json, j.dump(2) + "\n");
    fmt::print("{}, {}, {}x{} pixels; loaded in {:.2f} s, built in {:.2f} s\n{}", r.scene,
               a.speed.choice.name(), scene.camera().window().width, scene.camera().window().height, read,
               build, study::speedTable(j["passes"], j["techniques"]));
    return kDone;
}

}  // namespace

Run addBenchCommand(CLI::App& parent) {
    CLI::App* app = parent.add_subcommand("bench", "Measure the speed of an integrator on a scene");
    app->footer(kBenchExamples);
    auto a = std::make_shared<BenchArguments>();
    app->add_option("scene", a->render.scene, "Mitsuba scene (XML)")->required();
    app->add_option("--passes", a->speed.passes, "Passes to measure (default: 5)")
        ->option_text("N")
        ->check(wholeNumber<uint32_t>(1, 1u << 20));
    app->add_option("--json", a->json, "File for all numbers")->option_text("FILE");
    addSceneOptions(*app, a->render);
    addAlgorithmOptions(*app, a->render);
    addMachineOptions(*app, a->render);
    return [a] { return bench(*a); };
}

}  // namespace metrolux::core::app
