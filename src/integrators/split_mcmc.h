#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// Vertex connection and merging of eye and light subpaths that each come from visibility-driven chains
/// (supplement of [Sik16], section 4.2). A light subpath is visible if it touches a pixel, an eye subpath if
/// one of its vertices lies within the merging radius of a light vertex of the last iteration.
std::unique_ptr<Integrator> makeSplitMcmcIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
