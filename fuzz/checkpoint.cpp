/// Checkpoints. Each input is read as it is, and once more behind a header that suits it, so that what the
/// checksum guards is reached too: merging, and going on with a rendering of the named integrator.

#include "render/checkpoint.h"

#include "base/state_archive.h"
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

/// With the corpus' number of lanes, and those options that decide about the shape of a state.
IntegratorOptions optionsOf(const nlohmann::json& algorithm) {
    const auto is = [&](const char* option, const char* value) {
        return algorithm.contains(option) && algorithm[option] == value;
    };
    IntegratorOptions options;
    options.lanes = 2;
    options.limits.maxDepth = 6;
    if (is("method", "A")) options.mergeMethod = 'A';
    if (is("normalization", "bennett")) options.normalization = NormalizationMethod::Bennett;
    options.measuredSplit = is("split", "auto") && is("integrator", "mcmc_vcm");
    if (is("kernel", "adaptive")) options.kernel = MutationKernel::Kind::Adaptive;
    return options;
}

/// What `metrolux resume` does with a state, and a pass.
void resume(const Checkpoint& checkpoint) {
    constexpr uint32_t kStreams = 16;
    const nlohmann::json algorithm = nlohmann::json::parse(checkpoint.identity)["algorithm"];
    const auto integrators = integratorList();
    std::string name = algorithm["integrator"];
    const auto isName = [&](const auto& known) { return known.first == name; };
    if (std::none_of(integrators.begin(), integrators.end(), isName)) name = "path";
    StreamedIntegrator integrator(
        [&](uint32_t) { return makeIntegrator(name, smallScene(), optionsOf(algorithm)); },
        {kStreams, 0, kStreams - 1}, 0);
    integrator.restore(checkpoint.streams);
    Film film = makeFilm(smallScene());
    StateReader reader(checkpoint.film);
    film.loadState(reader);
    reader.checkEnd();
    integrator.renderPass(film);
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
