#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// Multiplexed Metropolis light transport (Hachisuka, Kaplanyan, Dachsbacher 2014): for each path length,
/// chains whose state also says which technique (s, t) makes the path; each technique is weighted by multiple
/// importance sampling, so that chains prefer the technique that does well.
std::unique_ptr<Integrator> makeMmltIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
