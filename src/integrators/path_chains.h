#pragma once
/// What the integrators share whose chains make complete paths: pssmlt, mmlt, pssmlt_merge.

#include "integrators/integrator.h"
#include "integrators/path_pair.h"
#include "markov/metropolis.h"

namespace metrolux::core {

/// What a point of primary sample space contributes to the image.
struct PathValue {
    SplatList splats;
    double size = 0;  ///< F(u)
    template <class Archive>
    void serialize(Archive& archive) {
        archive(splats, size);
    }
};
using PathSampler = MetropolisSampler<PathValue>;

/// Options of a sampler that takes `stepsPerPass` steps; `name` tells the integrator's samplers apart.
MetropolisOptions pathSamplerOptions(const IntegratorOptions& options, size_t stepsPerPass, uint64_t name);

/// Evaluates a pair of subpaths, all techniques.
inline auto evaluatorOf(const PathPair& pair) {
    return [&pair](SampleStream& u, PathValue& value) {
        pair.all(u, value.splats);
        value.size = value.splats.size();
    };
}
/// Adds weight * value to a film, as a part `share` of a pass.
inline auto payTo(Film& film, double share = 1) {
    return [&film, share](const PathValue& value, double weight) {
        film.addSplats(value.splats, weight * share);
    };
}

/// Of a sampler that was loaded: throws Error if it holds a splat on a pixel that the film does not have.
void checkPixels(const PathSampler& sampler, const FilmWindow& window);

nlohmann::json samplerStatistics(const PathSampler& sampler);
/// What the options say about chains.
nlohmann::json chainStatistics(const IntegratorOptions& options);
/// Acceptance rates, for the progress line.
std::string acceptanceNote(const PathSampler::Counts& counts);

}  // namespace metrolux::core
