#pragma once
/// Single rays as Embree takes them.

#include "geometry/ray_batch.h"

#include <embree3/rtcore.h>

namespace metrolux::core {

/// Carries the local rays of the nearest analytic hits out of the traversal; the interaction is computed from
/// them once, when the nearest hit of all is known. A ray's `id` is its place here.
struct QueryContext {
    RTCIntersectContext embree;
    Ray* analyticRays;
};

inline Ray toRay(const RTCRay& r) {
    return {{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.tfar};
}

inline RTCRay toEmbree(const Ray& ray) {
    RTCRay r{};
    r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
    r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
    r.tnear = 0;
    r.tfar = ray.tMax;
    r.mask = ~0u;
    return r;
}

/// A query for the nearest hit; true if there is one.
inline bool nearest(RTCScene scene, const Ray& ray, RTCRayHit& query, Ray& analyticRay) {
    QueryContext context;
    context.analyticRays = &analyticRay;
    rtcInitIntersectContext(&context.embree);
    query.ray = toEmbree(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context.embree, &query);
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

/// Whether anything lies within (0, ray.tMax).
inline bool anything(RTCScene scene, const Ray& ray) {
    if (!(ray.tMax > 0)) return false;
    QueryContext context;
    rtcInitIntersectContext(&context.embree);
    RTCRay query = toEmbree(ray);
    rtcOccluded1(scene, &context.embree, &query);
    return query.tfar < 0;
}

}  // namespace metrolux::core
