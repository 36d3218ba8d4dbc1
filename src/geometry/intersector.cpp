#include "geometry/intersector.h"

#include "base/error.h"
#include "base/parallel.h"
#include "geometry/affine.h"
#include "geometry/ray_counters.h"

#include <embree3/rtcore.h>

#include <cstring>
#include <mutex>
#include <unordered_map>

namespace metrolux {

namespace {

/// Under the thread sanitizer Embree builds its trees in the calling thread: see base/parallel.h.
#ifdef METROLUX_UNDER_THREAD_SANITIZER
constexpr const char* kDeviceOptions = "threads=1";
#else
constexpr const char* kDeviceOptions = nullptr;
#endif

/// Carries the local ray of the nearest analytic hit out of the traversal; the interaction is computed from
/// it once, when the nearest hit of all is known.
struct QueryContext {
    RTCIntersectContext embree;
    Ray analyticRay;
};

Ray toRay(const RTCRay& r) { return {{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.tfar}; }

RTCRay toEmbree(const Ray& ray) {
    RTCRay r{};
    r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
    r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
    r.tnear = 0;
    r.tfar = ray.tMax;
    r.mask = ~0u;
    return r;
}

// The callbacks serve single rays only (rtcIntersect1, rtcOccluded1), for which RTCRayHitN has the layout of
// RTCRayHit.

void boundsOfAnalytic(const RTCBoundsFunctionArguments* arguments) {
    Vec3f lower, upper;
    static_cast<const AnalyticShape*>(arguments->geometryUserPtr)->bounds(lower, upper);
    RTCBounds& b = *arguments->bounds_o;
    b.lower_x = lower.x, b.lower_y = lower.y, b.lower_z = lower.z;
    b.upper_x = upper.x, b.upper_y = upper.y, b.upper_z = upper.z;
}

void intersectAnalytic(const RTCIntersectFunctionNArguments* arguments) {
    if (!arguments->valid[0]) return;
    auto* rayHit = reinterpret_cast<RTCRayHit*>(arguments->rayhit);
    const auto* shape = static_cast<const AnalyticShape*>(arguments->geometryUserPtr);
    const Ray ray = toRay(rayHit->ray);
    float t = rayHit->ray.tfar;
    if (!shape->intersect(ray, rayHit->ray.tnear, t, nullptr)) return;
    rayHit->ray.tfar = t;
    rayHit->hit.geomID = arguments->geomID;
    rayHit->hit.primID = 0;
    rayHit->hit.instID[0] = arguments->context->instID[0];
    reinterpret_cast<QueryContext*>(arguments->context)->analyticRay = ray;
}

void occludedAnalytic(const RTCOccludedFunctionNArguments* arguments) {
    if (!arguments->valid[0]) return;
    auto* r = reinterpret_cast<RTCRay*>(arguments->ray);
    float t = r->tfar;
    if (static_cast<const AnalyticShape*>(arguments->geometryUserPtr)
            ->intersect(toRay(*r), r->tnear, t, nullptr))
        r->tfar = -kInfinity;
}

/// A shape by its kind: one of the two is set.
struct Target {
    const TriangleMesh* mesh = nullptr;
    const AnalyticShape* analytic = nullptr;

    explicit Target(const Shape& shape)
        : mesh(dynamic_cast<const TriangleMesh*>(&shape)),
          analytic(dynamic_cast<const AnalyticShape*>(&shape)) {
        if (!mesh && !analytic) throw Error("shape \"{}\" is neither a mesh nor an analytic shape", shape.id);
    }
};

/// What a committed scene of Embree consists of, by geometry id.
struct Group {
    RTCScene scene = nullptr;
    std::vector<Target> targets;
};

struct PlacedGroup {
    const Group* group;
    Transform toWorld;
};

}  // namespace

struct Intersector::Impl {
    std::vector<ShapePtr> keptShapes;
    std::vector<std::shared_ptr<const ShapeGroup>> keptGroups;
    RTCDevice device = nullptr;
    Group top;
    std::unordered_map<const ShapeGroup*, Group> groups;
    std::vector<PlacedGroup> instances;  // by geometry id of the top level, after its shapes
    std::mutex errorMutex;
    std::string error;  // the first that Embree reported

    Impl() {
        // Embree's flush-to-zero modes stay off: they would belong in every thread that traces, and results
        // must not depend on the thread.
        device = rtcNewDevice(kDeviceOptions);
        if (!device)
            throw Error("Embree: no device (error {})", static_cast<int>(rtcGetDeviceError(nullptr)));
        rtcSetDeviceErrorFunction(
            device,
            [](void* self, RTCError code, const char* text) {
                auto& impl = *static_cast<Impl*>(self);
                const std::lock_guard lock(impl.errorMutex);
                if (impl.error.empty())
                    impl.error = fmt::format("{} (error {})", text, static_cast<int>(code));
            },
            this);
    }
    ~Impl() {
        if (top.scene) rtcReleaseScene(top.scene);
        for (auto& [key, group] : groups)
            if (group.scene) rtcReleaseScene(group.scene);
        rtcReleaseDevice(device);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void check(const std::string& what) {
        const std::lock_guard lock(errorMutex);
        if (!error.empty()) throw Error("Embree: {} while {}", error, what);
    }

    void attach(RTCScene target, RTCGeometry geometry, size_t id, const std::string& what) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(target, geometry, static_cast<unsigned>(id));
        rtcReleaseGeometry(geometry);
        check(what);
    }

    /// Lets Embree read a vector in place where 16 bytes at its last element are allocated, copies it
    /// otherwise.
    template <class T>
    void setBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t stride, size_t count,
                   const std::vector<T>& data) {
        if (data.capacity() * sizeof(T) >= data.size() * sizeof(T) + 16 - std::min<size_t>(stride, 16)) {
            rtcSetSharedGeometryBuffer(geometry, type, 0, format, data.data(), 0, stride, count);
            return;
        }
        void* copy = rtcSetNewGeometryBuffer(geometry, type, 0, format, stride, count);
        check("allocating a mesh");
        std::memcpy(copy, data.data(), stride * count);
    }

    RTCGeometry newGeometry(const Target& target) {
        if (const TriangleMesh* mesh = target.mesh) {
            RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
            check("making a mesh");
            setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                      mesh->positions.size(), mesh->positions);
            setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                      mesh->primitiveCount(), mesh->indices);
            return geometry;
        }
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        check("making an analytic shape");
        rtcSetGeometryUserPrimitiveCount(geometry, 1);
        rtcSetGeometryUserData(geometry, const_cast<AnalyticShape*>(target.analytic));
        rtcSetGeometryBoundsFunction(geometry, boundsOfAnalytic, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersectAnalytic);
        rtcSetGeometryOccludedFunction(geometry, occludedAnalytic);
        return geometry;
    }

    /// Makes the scene of a group; the caller commits it.
    void fill(Group& group, const std::vector<ShapePtr>& shapes) {
        group.scene = rtcNewScene(device);
        check("making a scene");
        rtcSetSceneFlags(group.scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(group.scene, RTC_BUILD_QUALITY_HIGH);
        for (const ShapePtr& shape : shapes) {
            group.targets.emplace_back(*shape);
            attach(group.scene, newGeometry(group.targets.back()), group.targets.size() - 1,
                   fmt::format("attaching shape \"{}\"", shape->id));
        }
    }

    void attachInstance(const Instance& instance, const Group& group) {
        const Affine map(instance.toWorld);
        float columns[12];
        for (int i = 0; i < 3; ++i) {
            columns[i] = static_cast<float>(map.x[i]);
            columns[3 + i] = static_cast<float>(map.y[i]);
            columns[6 + i] = static_cast<float>(map.z[i]);
            columns[9 + i] = static_cast<float>(map.offset[i]);
        }
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        check("making an instance");
        rtcSetGeometryInstancedScene(geometry, group.scene);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
        attach(top.scene, geometry, top.targets.size() + instances.size(), "attaching an instance");
        instances.push_back({&group, instance.toWorld});
    }
};

Intersector::Intersector(const std::vector<ShapePtr>& shapes, const std::vector<Instance>& instances)
    : impl_(std::make_unique<Impl>()) {
    Impl& impl = *impl_;
    impl.keptShapes = shapes;
    impl.fill(impl.top, shapes);
    for (const Instance& instance : instances) {
        const auto [it, isNew] = impl.groups.try_emplace(instance.group.get());
        Group& group = it->second;
        if (isNew) {
            impl.keptGroups.push_back(instance.group);
            impl.fill(group, instance.group->shapes);
            rtcCommitScene(group.scene);
            impl.check("building a shape group");
        }
        impl.attachInstance(instance, group);
    }
    rtcCommitScene(impl.top.scene);
    impl.check("building the scene");
}

Intersector::~Intersector() = default;

namespace {

/// A query for the nearest hit; true if there is one.
bool nearest(RTCScene scene, const Ray& ray, QueryContext& context, RTCRayHit& query) {
    rtcInitIntersectContext(&context.embree);
    query.ray = toEmbree(ray);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context.embree, &query);
    return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

bool anything(RTCScene scene, const Ray& ray) {
    QueryContext context;
    rtcInitIntersectContext(&context.embree);
    RTCRay query = toEmbree(ray);
    rtcOccluded1(scene, &context.embree, &query);
    return query.tfar < 0;
}

}  // namespace

bool Intersector::intersect(const Ray& ray, SurfaceInteraction& si) const {
    QueryContext context;
    RTCRayHit query;
    bool found;
    {
        const RayTimer timer(&RayCounters::intersectRays);
        found = nearest(impl_->top.scene, ray, context, query);
    }
    if (RayRecorder* recorder = RayRecorder::active()) recorder->add({ray, false, found});
    if (!found) return false;
    const RTCHit& hit = query.hit;
    const bool instanced = hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
    const PlacedGroup* placed =
        instanced ? &impl_->instances[hit.instID[0] - impl_->top.targets.size()] : nullptr;
    const Target& target = (placed ? *placed->group : impl_->top).targets[hit.geomID];
    if (target.mesh) {
        target.mesh->interaction(hit.primID, Vec2f(hit.u, hit.v), si);
    } else {
        // The same call with the same ray as in the traversal: it finds the same hit.
        float t = kInfinity;
        target.analytic->intersect(context.analyticRay, 0, t, &si);
    }
    if (placed) {
        const Transform& m = placed->toWorld;
        si.p = m.point(si.p);
        si.ng = normalize(m.normal(si.ng));
        si.ns = normalize(m.normal(si.ns));
        si.placement = &m;
        si.s = Frame::fromNormalAndTangent(si.ns, partials(si).dpdu).s;
    } else {
        si.placement = nullptr;
    }
    return true;
}

bool Intersector::occluded(const Ray& ray) const {
    bool found;
    {
        const RayTimer timer(&RayCounters::shadowRays);
        found = anything(impl_->top.scene, ray);
    }
    if (RayRecorder* recorder = RayRecorder::active()) recorder->add({ray, true, found});
    return found;
}

size_t Intersector::replay(std::span<const RecordedRay> rays) const {
    size_t different = 0;
    QueryContext context;
    RTCRayHit query;
    for (const RecordedRay& r : rays) {
        const bool found = r.occlusion ? anything(impl_->top.scene, r.ray)
                                       : nearest(impl_->top.scene, r.ray, context, query);
        different += found != r.hit;
    }
    return different;
}

std::string Intersector::libraryVersion() {
    return fmt::format("{}.{}.{}", RTC_VERSION_MAJOR, RTC_VERSION_MINOR, RTC_VERSION_PATCH);
}

void Intersector::bounds(Vec3f& lower, Vec3f& upper) const {
    RTCBounds b;
    rtcGetSceneBounds(impl_->top.scene, &b);
    lower = {b.lower_x, b.lower_y, b.lower_z};
    upper = {b.upper_x, b.upper_y, b.upper_z};
    if (!(lower.x <= upper.x)) lower = upper = Vec3f(0.0f);  // empty
}

}  // namespace metrolux
