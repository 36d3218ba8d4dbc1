#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// Unidirectional path tracing: hit and next-event estimation, balance heuristic.
std::unique_ptr<Integrator> makePathIntegrator(const Scene& scene, const IntegratorOptions& options);

/// Light tracing: every light vertex is connected to the camera; emitters seen directly are hit by eye rays.
/// Cannot see what the camera sees through delta lobes only.
std::unique_ptr<Integrator> makeLightIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
