/// Checkpoints. Each input is read as it is, and once more behind a header that suits it, so that what the
/// checksum guards is reached too: merging, and going on with a rendering of the named integrator.

#include "render/checkpoint.h"

#include "base/state_archive.h"
#include "integrators/registry.h"
#include "render/merge.h"
#include "sandbox.h"
#include "support/small_scenes.h"

using namespace metrolux::core;

namespace {

const std::string kName = "fuzzed";

/// As large as the images of the corpus (make_checkpoints.sh); states do not depend on what is in a scene.
const Scene& smallScene() {
    static const std::shared_ptr<Scene> scene = [] {
        test::SceneBuilder builder;
        builder.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 2, 2), test::diffuse(0.6f));
        const ShapePtr light =
            builder.add(test::rectangle({0, 2, 0}, {0, -1, 0}, 0.5f, 0.5f), test::diffuse(0));
        builder.emit(light, Rgb(5.0f));
        builder.camera({0, 1, -4}, {0, 0.5f, 0}, 50, 6, 4);
        return builder.build();
    }();
    return *scene;
}

/// The parameters of the file where they are some, with the corpus' number of lanes: they decide about the
/// shape of a state.
std::unique_ptr<Integrator> integratorOf(const IntegratorDescription& integrator,
                                         const nlohmann::json& algorithm) {
    ParameterSet set(integrator.parameters);
    for (const ParameterInfo& info : integrator.parameters) {
        const nlohmann::json::json_pointer at("/parameters/" + info.name);
        if (!algorithm.contains(at)) continue;
        const nlohmann::json& value = algorithm.at(at);
        try {
            set.set(info.name, value.is_string() ? value.get<std::string>() : value.dump());
        } catch (const Error&) {
            continue;  // the default then
        }
    }
    if (set.find("lanes")) set.set("lanes", 2);
    CommonOptions options;
    options.limits.maxDepth = 6;
    return integrator.prepare(smallScene(), options, set)(options.seed);
}

/// What `metrolux resume` does with a state, and a pass.
void resume(const Checkpoint& checkpoint) {
    constexpr uint32_t kSlices = 16;
    const nlohmann::json algorithm = nlohmann::json::parse(checkpoint.identity)["algorithm"];
    const auto& list = integratorList();
    const auto named = std::find_if(list.begin(), list.end(),
                                    [&](const auto& known) { return known.name == algorithm["integrator"]; });
    const IntegratorDescription& description = named == list.end() ? findIntegrator("path") : *named;
    SlicedIntegrator integrator([&](uint32_t) { return integratorOf(description, algorithm); },
                                {kSlices, 0, kSlices - 1}, 0);
    integrator.restore(checkpoint.slices);
    Film film = makeFilm(smallScene());
    StateReader reader(checkpoint.film);
    film.loadState(reader);
    reader.checkEnd();
    integrator.renderPass(film, film.passes());
    film.image();
    film.variance();
    film.relativeError();
    integrator.statistics();
    integrator.progressNote();
}

void merge(const Checkpoint& checkpoint) {
    PartMerger merger;
    merger.add(kName, checkpoint);
    merger.film().image();
    merger.missing();
    merger.add(kName, checkpoint);
}

/// The version is what the file says, so that the corpus outlives it.
std::string versionIn(std::string_view payload) {
    std::string version;
    StateReader reader(payload);
    reader(version);
    return version;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    const std::string_view input(reinterpret_cast<const char*>(data), size);
    fuzz::expectErrorsOnly(kName, [&] { parseCheckpoint(input, kName, "0.1.0"); });
    const std::string_view payload = input.substr(std::min(size, checkpointHeader({}).size()));
    try {
        const std::string version = versionIn(payload);
        std::optional<Checkpoint> checkpoint;
        fuzz::expectErrorsOnly(kName, [&] {
            checkpoint = parseCheckpoint(checkpointHeader(payload) + std::string(payload), kName, version);
        });
        if (!checkpoint) return 0;
        fuzz::expectErrorsOnly(kName, [&] { merge(*checkpoint); });
        resume(*checkpoint);
    } catch (const Error&) {
        // States do not know what file they are from.
    }
    return 0;
}
