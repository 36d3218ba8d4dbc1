#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// Vertex connection and merging [Geo12, HPJ12]: all techniques of docs/explain/algorithm.md section 1,
/// independent light subpaths.
std::unique_ptr<Integrator> makeVcmIntegrator(const Scene& scene, const IntegratorOptions& options);

/// Bidirectional path tracing [VG94, VG95]: the same without merging.
std::unique_ptr<Integrator> makeBdptIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
