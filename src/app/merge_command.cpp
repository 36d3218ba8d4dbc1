#include "app/commands.h"
#include "app/render_options.h"
#include "base/error.h"
#include "image/atomic_file.h"
#include "render/merge.h"

#include <spdlog/spdlog.h>

namespace metrolux::core::app {
namespace {

constexpr const char* kExamples = R"(Examples:
  metrolux render scene.xml --passes 6400 --streams 64 --only-streams 0-31 --checkpoint part0     # on one machine
  metrolux render scene.xml --passes 6400 --streams 64 --only-streams 32-63 --checkpoint part1    # on another
  metrolux merge part0 part1 -o image.exr -o image.png

The image is that of one process which renders all streams, bit for bit. Parts weigh as many as they have passes.
Parts of another scene, other options or another version, damaged ones and parts that overlap are refused;
missing streams are warned of: the image is right without them, and noisier.)";

struct MergeArguments {
    std::vector<std::string> parts;
    RenderArguments render;  ///< outputs
};

RenderedFrame frameOf(const PartMerger& merger, const std::vector<Aov>& aovs) {
    RenderedFrame frame;
    const Film& film = merger.film();
    const nlohmann::json& identity = merger.identity();
    frame.image = {film.width(), film.height(), 3, film.image()};
    for (Aov aov : aovs) {
        if (aov != Aov::Variance)
            throw Error(
                "--aov: of the layers only variance is in the parts; render the others with the scene");
        frame.layers.push_back(varianceLayer(film));
    }
    frame.metadata = {{"Software", std::string("Metrolux ") + METROLUX_VERSION},
                      {"metrolux:scene", identity["scene"]["name"].get<std::string>()},
                      {"metrolux:integrator", identity["algorithm"]["integrator"].get<std::string>()},
                      {"metrolux:passes", static_cast<int>(film.passes())},
                      {"metrolux:seconds", merger.seconds()},
                      {"metrolux:seed", identity["algorithm"]["seed"].dump()}};
    return frame;
}

nlohmann::json statisticsOf(const PartMerger& merger, const std::vector<std::string>& parts) {
    nlohmann::json streams = nlohmann::json::object();
    for (const auto& [stream, passes] : merger.passes()) streams[std::to_string(stream)] = passes;
    return {{"version", METROLUX_VERSION},
            {"parts", parts},
            {"rendering", merger.identity()},
            {"passes", merger.film().passes()},
            {"seconds", merger.seconds()},
            {"passes_of_streams", streams},
            {"missing_streams", merger.missing()},
            {"rays", {{"intersect", merger.rays().intersectRays}, {"shadow", merger.rays().shadowRays}}},
            {"non_finite", nonFiniteCounts(merger.film())}};
}

int merge(MergeArguments& a) {
    RenderArguments& options = a.render;
    if (options.quiet) spdlog::set_level(spdlog::level::warn);
    if (options.outputs.empty()) throw Error("there is no image to write: name it with -o FILE");
    prepareOutputs(options);
    PartMerger merger;
    for (const std::string& part : a.parts) merger.add(part, readCheckpoint(part, METROLUX_VERSION));
    if (const std::vector<uint32_t> missing = merger.missing(); !missing.empty())
        spdlog::warn("{} of {} streams are missing: {}", missing.size(),
                     merger.identity()["streams"].get<uint32_t>(), fmt::join(missing, ", "));
    checkDistinct(namedOutputs(options), std::vector<std::filesystem::path>(a.parts.begin(), a.parts.end()));
    const OutputSet outputs(options.session.outputs, options.session.display, options.session.overwrite);
    SessionResult result;
    result.reason = StopReason::Passes;
    result.passes = merger.film().passes();
    result.statistics = statisticsOf(merger, a.parts);
    result.written = outputs.writeOrRescue(frameOf(merger, options.session.aovs));
    reportNonFinite(result.statistics["non_finite"]);
    return conclude(result, options);
}

}  // namespace

Run addMergeCommand(CLI::App& parent) {
    CLI::App* app =
        parent.add_subcommand("merge", "Join the parts of a rendering that was divided into streams");
    app->footer(kExamples);
    auto arguments = std::make_shared<MergeArguments>();
    app->add_option("parts", arguments->parts, "Checkpoints of `metrolux render --only-streams`")
        ->required()
        ->option_text("PART...");
    addOutputOptions(*app, arguments->render);
    return [arguments] { return merge(*arguments); };
}

}  // namespace metrolux::core::app
