#include "render/merge.h"

#include "api/internals.h"
#include "api/log.h"
#include "base/printable.h"

#include <metrolux/version.h>

namespace metrolux {
namespace {

/// Sets `denoiser` if it denoises.
core::RenderedFrame frameOf(const core::PartMerger& merger, const std::vector<std::string>& layers,
                            std::string& denoiser) {
    core::RenderedFrame frame;
    const core::Film& film = merger.film();
    const nlohmann::json& identity = merger.identity();
    frame.image = {film.width(), film.height(), 3, film.image(), core::placeOf(film.window())};
    for (const std::string& layer : layers) {
        const core::Aov aov = core::aovFromName(layer);
        if (aov == core::Aov::Variance) {
            frame.layers.push_back(core::varianceLayer(film));
        } else if (aov == core::Aov::Denoised) {
            if (!merger.denoising())
                throw core::Error(
                    "--denoise: the parts have no halves of their passes, render them with --denoise");
            const core::DenoisingState& state = *merger.denoising();
            core::DenoisedImage denoised = core::denoise(film, state.halves, state.features);
            frame.layers.push_back(std::move(denoised.layer));
            denoiser = denoised.denoiser;
            for (const std::string& warning : denoised.warnings) core::api::log(LogLevel::Warning, warning);
        } else {
            throw core::Error(
                "--aov: of the layers only variance is in the parts; render the others with the scene");
        }
    }
    frame.metadata = {{"Software", std::string("Metrolux ") + version()},
                      {"metrolux:scene", identity["scene"]["name"].get<std::string>()},
                      {"metrolux:integrator", identity["algorithm"]["integrator"].get<std::string>()},
                      {"metrolux:passes", static_cast<int>(film.passes())},
                      {"metrolux:seconds", merger.seconds()},
                      {"metrolux:seed", identity["algorithm"]["seed"].dump()},
                      {"metrolux:options", identity["algorithm"].dump()}};
    if (!denoiser.empty()) frame.metadata.emplace_back("metrolux:denoiser", denoiser);
    return frame;
}

nlohmann::json statisticsOf(const core::PartMerger& merger, const std::vector<std::filesystem::path>& parts,
                            const std::string& denoiser) {
    nlohmann::json slices = nlohmann::json::object(), names = nlohmann::json::array();
    for (const auto& [slice, passes] : merger.passes()) slices[std::to_string(slice)] = passes;
    for (const std::filesystem::path& part : parts) names.push_back(core::validUtf8(part.string()));
    return {{"version", version()},
            {"parts", names},
            {"rendering", merger.identity()},
            {"passes", merger.film().passes()},
            {"seconds", merger.seconds()},
            {"passes_of_slices", slices},
            {"missing_slices", merger.missing()},
            {"rays", {{"intersect", merger.rays().intersectRays}, {"shadow", merger.rays().shadowRays}}},
            {"denoiser", denoiser},
            {"emission_exponent", merger.film().exponent()},
            {"beyond_single_precision", merger.film().beyondFloat()},
            {"non_finite", core::toJson(merger.nonFinite())}};
}

}  // namespace

Merged merge(const std::vector<std::filesystem::path>& parts, const Files& files,
             const std::vector<std::string>& layers) {
    if (parts.empty()) throw core::Error("there are no parts to merge");
    core::checkDistinct(core::api::namedOutputs(files), parts);
    const core::OutputSet outputs(files.images, core::api::displayOf(files.display), files.overwrite);
    core::PartMerger merger;
    for (const std::filesystem::path& part : parts)
        merger.add(part.string(), core::readCheckpoint(part, version()));
    if (merger.hasOtherBuilds())
        core::api::log(
            LogLevel::Warning,
            "the parts come from different builds or machines: the image is right, but in last bits "
            "not that of one process");
    if (const std::vector<uint32_t> missing = merger.missing(); !missing.empty())
        core::api::log(LogLevel::Warning, fmt::format("{} of {} slices are missing: {}", missing.size(),
                                                      merger.identity()[core::kSliceCountKey].get<uint32_t>(),
                                                      fmt::join(missing, ", ")));
    std::string denoiser;
    const core::OutputSet::RescueResult written = outputs.writeOrRescue(frameOf(merger, layers, denoiser));
    return {{StopReason::Passes, merger.film().passes(), written.failures, written.rescued, {}},
            statisticsOf(merger, parts, denoiser).dump(2)};
}

}  // namespace metrolux
