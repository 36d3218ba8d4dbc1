#pragma once
/// Queries as Embree takes them: the only place where Embree 3 and 4 differ.

#include "geometry/ray_batch.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <type_traits>

namespace metrolux::core {

#if RTC_VERSION_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
#else
using EmbreeContext = RTCIntersectContext;
#endif

/// What accompanies a query through the traversal. Embree's callbacks get a pointer to its first member.
struct QueryContext {
    EmbreeContext embree;
    /// Carries the local rays of the nearest analytic hits out of the traversal; the interaction is computed
    /// from them once, when the nearest hit of all is known. A ray's `id` is its place here.
    Ray* analyticRays = nullptr;
#if RTC_VERSION_MAJOR >= 4
    RTCRayQueryFlags flags = RTC_RAY_QUERY_FLAG_INCOHERENT;
#endif

    /// `coherent`: the rays of each packet start and run close to each other.
    explicit QueryContext(bool coherent = false) {
#if RTC_VERSION_MAJOR >= 4
        rtcInitRayQueryContext(&embree);
        if (coherent) flags = RTC_RAY_QUERY_FLAG_COHERENT;
#else
        rtcInitIntersectContext(&embree);
        if (coherent) embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
#endif
    }

    /// `function`: one of rtcIntersect1, 4, 8 and 16; `valid`: for packets, -1 for each ray that is traced
    /// and 0 for the others.
    template <class Function, class Query, class... Valid>
    void intersect(Function function, RTCScene scene, Query& query, Valid... valid) {
#if RTC_VERSION_MAJOR >= 4
        RTCIntersectArguments arguments;
        rtcInitIntersectArguments(&arguments);
        arguments.flags = flags;
        arguments.context = &embree;
        function(valid..., scene, &query, &arguments);
#else
        function(valid..., scene, &embree, &query);
#endif
    }
    /// The same for one of rtcOccluded1, 4, 8 and 16.
    template <class Function, class Query, class... Valid>
    void occluded(Function function, RTCScene scene, Query& query, Valid... valid) {
#if RTC_VERSION_MAJOR >= 4
        RTCOccludedArguments arguments;
        rtcInitOccludedArguments(&arguments);
        arguments.flags = flags;
        arguments.context = &embree;
        function(valid..., scene, &query, &arguments);
#else
        function(valid..., scene, &embree, &query);
#endif
    }
};
static_assert(std::is_standard_layout_v<QueryContext>);

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
    query.ray = toEmbree(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    context.intersect(rtcIntersect1, scene, query);
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

/// Whether anything lies within (0, ray.tMax).
inline bool anything(RTCScene scene, const Ray& ray) {
    if (!(ray.tMax > 0)) return false;
    QueryContext context;
    RTCRay query = toEmbree(ray);
    context.occluded(rtcOccluded1, scene, query);
    return query.tfar < 0;
}

}  // namespace metrolux::core
