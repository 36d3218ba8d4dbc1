#include "base/error.h"
#include "base/suggest.h"
#include "integrators/integrator.h"
#include "integrators/mcmc_vcm.h"
#include "integrators/mmlt.h"
#include "integrators/path.h"
#include "integrators/photon_mapping.h"
#include "integrators/pssmlt.h"
#include "integrators/pssmlt_merge.h"
#include "integrators/split_mcmc.h"
#include "integrators/vcm.h"

#include <functional>

namespace metrolux::core {

namespace {

struct Entry {
    const char* name;
    const char* description;
    std::unique_ptr<Integrator> (*make)(const Scene&, const IntegratorOptions&);
};

constexpr Entry kIntegrators[] = {
    {"mcmc_vcm", "VCM whose light subpaths come from Markov chains (default; robust on hard light)",
     makeMcmcVcmIntegrator},
    {"vcm", "vertex connection and merging, independent light subpaths", makeVcmIntegrator},
    {"bdpt", "bidirectional path tracing", makeBdptIntegrator},
    {"path", "path tracing with next-event estimation", makePathIntegrator},
    {"sppm", "stochastic progressive photon mapping", makeSppmIntegrator},
    {"vpt", "photon mapping whose photons are driven to where the camera sees them", makeVptIntegrator},
    {"split_mcmc", "VCM with eye and light subpaths from separate visibility-driven chains",
     makeSplitMcmcIntegrator},
    {"light", "light tracing: light subpaths connected to the camera", makeLightIntegrator},
    {"pssmlt", "primary sample space Metropolis light transport on bidirectional path tracing",
     makePssmltIntegrator},
    {"mmlt", "multiplexed Metropolis light transport: chains choose technique and path", makeMmltIntegrator},
    {"pssmlt_merge", "pssmlt that also merges with light subpaths from chains (method A or B of the paper)",
     makePssmltMergeIntegrator},
};

}  // namespace

std::vector<std::pair<std::string, std::string>> integratorList() {
    std::vector<std::pair<std::string, std::string>> result;
    for (const Entry& e : kIntegrators) result.emplace_back(e.name, e.description);
    return result;
}

Film makeFilm(const Scene& scene) {
    return {scene.camera().window(), ReconstructionFilter(scene.parts().filterKind, scene.parts().filter)};
}

std::unique_ptr<Integrator> makeIntegrator(const std::string& name, const Scene& scene,
                                           const IntegratorOptions& options) {
    std::vector<std::string> names;
    for (const Entry& e : kIntegrators) {
        if (name == e.name) return e.make(scene, options);
        names.emplace_back(e.name);
    }
    const std::string near = nearestName(name, names);
    throw Error("unknown integrator '{}'{}; known: {}", name,
                near.empty() ? "" : fmt::format(", did you mean '{}'?", near), fmt::join(names, ", "));
}

}  // namespace metrolux::core
