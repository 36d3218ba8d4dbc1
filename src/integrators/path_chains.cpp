#include "integrators/path_chains.h"

#include "integrators/iteration.h"
#include "sampling/streams.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {
double share(uint64_t a, uint64_t b) { return b ? double(a) / double(b) : 0.0; }
}  // namespace

MetropolisOptions pathSamplerOptions(uint64_t seed, const MetropolisParameters& parameters,
                                     size_t stepsPerPass, uint64_t name) {
    MetropolisOptions result;
    result.key = hashKey(seed, StreamPurpose::Chain, name);
    result.lanes = laneCount(parameters.chains, stepsPerPass);
    result.kind = parameters.chains.kernel;
    result.largeStep = parameters.largeStep;
    // A few passes' worth: what is found before the first pass should not take much longer than it.
    constexpr size_t kFewestSamples = 2048, kMostSamples = 16384;
    result.poolSamples = std::clamp(4 * stepsPerPass, kFewestSamples, kMostSamples);
    result.steeringSamples = result.poolSamples / 4;
    return result;
}

void checkPixels(const PathSampler& sampler, const FilmWindow& window) {
    for (size_t i = 0; i < sampler.lanes(); ++i)
        for (const SplatList::PixelSplat& splat : sampler.value(i).splats.pixels)
            checkState(splat.pixel < static_cast<uint32_t>(window.pixelCount()), "pixels of the film");
}

nlohmann::json samplerStatistics(const PathSampler& sampler) {
    const PathSampler::Counts c = sampler.counts();
    nlohmann::json j{
        {"b", {{"value", sampler.pool().mean()}}},
        {"uniform_samples", sampler.pool().drawn()},
        {"starts", c.starts},
        {"small_steps",
         {{"tried", c.mutationsTried}, {"acceptance", share(c.mutationsAccepted, c.mutationsTried)}}},
        {"large_steps", {{"tried", c.largeTried}, {"acceptance", share(c.largeAccepted, c.largeTried)}}},
        {"theta_mean", c.theta}};
    if (sampler.pool().drawn() > 1) j["b"]["standard_error"] = sampler.pool().standardError();
    return j;
}

std::string acceptanceNote(const PathSampler::Counts& c) {
    if (c.starts == 0) return "no light found yet";
    return fmt::format("acceptance {:.2f}, large steps {:.2f}", share(c.mutationsAccepted, c.mutationsTried),
                       share(c.largeAccepted, c.largeTried));
}

}  // namespace metrolux::core
