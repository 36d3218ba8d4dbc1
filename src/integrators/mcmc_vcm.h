#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// Vertex connection and merging whose light subpaths come from Markov chains (Sik, Otsu, Hachisuka, Krivanek
/// 2016; docs/explain/algorithm.md section 3). Eye subpaths are stratified Monte Carlo.
std::unique_ptr<Integrator> makeMcmcVcmIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
