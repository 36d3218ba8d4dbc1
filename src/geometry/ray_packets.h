#pragma once
/// Batches of rays as packets, which Embree traces as a whole.

#include "geometry/embree_query.h"

namespace metrolux::core {

/// Fills `hits` of the batch, whose size they have. `width`: rays in a packet, one of 4, 8 and 16.
/// `analyticRays`: for the local rays of hits on analytic shapes (QueryContext), or null if there are none.
void intersectPackets(RTCScene scene, int width, Coherence coherence, RayBatch& batch, Ray* analyticRays);
/// Fills `blocked`, the same way.
void occludedPackets(RTCScene scene, int width, OcclusionBatch& batch);

}  // namespace metrolux::core
