#pragma once
#include "sampling/streams.h"
#include "transport/walk.h"

#include <functional>
#include <vector>

namespace metrolux::core {

/// An order of `count` light subpaths, given by their streams, in which those that start alike follow each
/// other: their first edges, the splats and merges at their ends and what lies in memory there are near. Says
/// nothing of what they contribute, so that sums over all are the same in any order.
///
/// They are sorted by where they are when they have gone the radius of the scene, which holds place and
/// direction: along a curve of Morton through a grid of about as many cells as subpaths.
std::vector<uint32_t> coherentOrder(const WalkRules& walk, size_t count,
                                    const std::function<IndependentStream(size_t)>& streamOf);

}  // namespace metrolux::core
