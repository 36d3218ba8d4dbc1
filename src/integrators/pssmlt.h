#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// Primary sample space Metropolis light transport [Kel02]: chains over the random numbers of bidirectional
/// path tracing, one eye and one light subpath in each step, target the luminance of all that they
/// contribute.
std::unique_ptr<Integrator> makePssmltIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
