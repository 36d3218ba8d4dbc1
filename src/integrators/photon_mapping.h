#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// Stochastic progressive photon mapping [Hachisuka & Jensen 2009], in the formulation of [Knaus & Zwicker
/// 2011] (one radius for all pixels, RadiusSchedule). At the first vertex of an eye subpath that has a smooth
/// lobe, all light that this lobe scatters is estimated from photons, direct light included; emitters are
/// seen directly and over delta lobes.
std::unique_ptr<Integrator> makeSppmIntegrator(const Scene& scene, const IntegratorOptions& options);

/// Visibility-driven photon tracing [HJ11]: the same with light subpaths from the uniform and the visibility
/// replica.
std::unique_ptr<Integrator> makeVptIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
