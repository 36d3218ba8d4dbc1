#pragma once
#include "geometry/ray_batch.h"
#include "transport/light_subpath_pass.h"

#include <span>

namespace metrolux::core {

/// Evaluates several light subpaths side by side, as an EyeWavefront traces eye subpaths: rays are traced
/// together, and memory that one waits for is prefetched while others are at work. What a subpath
/// contributes, and the order in which it does, depends on its own job only, as in
/// LightSubpathPass::evaluate. Coherence::Alone: to the bit, whichever others there are.
void evaluateTogether(const LightSubpathPass& pass, std::span<const LightSubpathJob> jobs,
                      Coherence coherence);

}  // namespace metrolux::core
