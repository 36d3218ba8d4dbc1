#include "geometry/ray_packets.h"

#include <algorithm>

namespace metrolux::core {

namespace {

/// Embree's types and functions for packets of N rays.
template <int N, class R, class H, auto intersectFunction, auto occludedFunction>
struct Packets {
    static constexpr int kWidth = N;
    using Rays = R;
    using RayHits = H;
    static constexpr auto intersect = intersectFunction;
    static constexpr auto occluded = occludedFunction;
};
using Packets4 = Packets<4, RTCRay4, RTCRayHit4, rtcIntersect4, rtcOccluded4>;
using Packets8 = Packets<8, RTCRay8, RTCRayHit8, rtcIntersect8, rtcOccluded8>;
using Packets16 = Packets<16, RTCRay16, RTCRayHit16, rtcIntersect16, rtcOccluded16>;

/// Calls body(packets) with the kind of this width, one of 4, 8 and 16.
template <class Body>
void withPackets(int width, Body&& body) {
    if (width == 16)
        body(Packets16());
    else if (width == 8)
        body(Packets8());
    else
        body(Packets4());
}

/// The packet's first `count` rays; the others are left out.
template <int N, class Rays>
void load(const Ray* rays, int count, Rays& packet, int* valid) {
    for (int k = 0; k < N; ++k) {
        const Ray& ray = rays[k < count ? k : 0];
        valid[k] = k < count && ray.tMax > 0 ? -1 : 0;
        packet.org_x[k] = ray.origin.x, packet.org_y[k] = ray.origin.y, packet.org_z[k] = ray.origin.z;
        packet.dir_x[k] = ray.direction.x, packet.dir_y[k] = ray.direction.y,
        packet.dir_z[k] = ray.direction.z;
        packet.tfar[k] = ray.tMax;
    }
}

/// What is the same for all packets.
template <int N, class Rays>
void initialize(Rays& packet) {
    for (int k = 0; k < N; ++k) {
        packet.tnear[k] = packet.time[k] = 0;
        packet.mask[k] = ~0u;
        packet.id[k] = static_cast<unsigned>(k);
        packet.flags[k] = 0;
    }
}

template <class P>
void intersectAll(RTCScene scene, Coherence coherence, RayBatch& batch, Ray* analyticRays) {
    constexpr int N = P::kWidth;
    typename P::RayHits packet;
    initialize<N>(packet.ray);
    alignas(64) int valid[N];
    QueryContext context(coherence == Coherence::High);
    for (size_t first = 0; first < batch.size(); first += N) {
        const int count = static_cast<int>(std::min<size_t>(N, batch.size() - first));
        load<N>(&batch.rays[first], count, packet.ray, valid);
        for (int k = 0; k < N; ++k) packet.hit.geomID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        context.analyticRays = analyticRays ? analyticRays + first : nullptr;
        context.intersect(P::intersect, scene, packet, valid);
        for (int k = 0; k < count; ++k)
            batch.hits[first + k] = {packet.hit.geomID[k],
                                     packet.hit.primID[k],
                                     packet.hit.instID[0][k],
                                     {packet.hit.u[k], packet.hit.v[k]}};
    }
}

template <class P>
void occludedAll(RTCScene scene, OcclusionBatch& batch) {
    constexpr int N = P::kWidth;
    typename P::Rays packet;
    initialize<N>(packet);
    alignas(64) int valid[N];
    QueryContext context;
    for (size_t first = 0; first < batch.size(); first += N) {
        const int count = static_cast<int>(std::min<size_t>(N, batch.size() - first));
        load<N>(&batch.rays[first], count, packet, valid);
        context.occluded(P::occluded, scene, packet, valid);
        for (int k = 0; k < count; ++k) batch.blocked[first + k] = packet.tfar[k] < 0;
    }
}

}  // namespace

void intersectPackets(RTCScene scene, int width, Coherence coherence, RayBatch& batch, Ray* analyticRays) {
    withPackets(
        width, [&](auto packets) { intersectAll<decltype(packets)>(scene, coherence, batch, analyticRays); });
}

void occludedPackets(RTCScene scene, int width, OcclusionBatch& batch) {
    withPackets(width, [&](auto packets) { occludedAll<decltype(packets)>(scene, batch); });
}

}  // namespace metrolux::core
