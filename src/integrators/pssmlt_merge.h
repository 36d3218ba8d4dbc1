#pragma once
#include "integrators/integrator.h"

namespace metrolux::core {

/// pssmlt whose eye subpaths are merged with a set L of light subpaths besides (supplement of Sik et al.
/// 2016, section 4.1), weighted as in vertex connection and merging. Method B: L from a visibility-driven
/// chain [HJ11]. Method A, experimental: L from the states of pssmlt's own chains, whose density is estimated
/// (biased).
std::unique_ptr<Integrator> makePssmltMergeIntegrator(const Scene& scene, const IntegratorOptions& options);

}  // namespace metrolux::core
