#include "geometry/intersector.h"

#include "base/error.h"
#include "base/parallel.h"
#include "geometry/affine.h"
#include "geometry/embree_query.h"
#include "geometry/ray_counters.h"
#include "geometry/ray_packets.h"
#include "geometry/ray_recorder.h"
#include "geometry/triangle_pairs.h"
#include "geometry/triangle_prefetch.h"

#include <cstring>
#include <mutex>
#include <new>
#include <unordered_map>

namespace metrolux::core {

namespace {

/// Under the thread sanitizer Embree builds its trees in the calling thread: see base/parallel.h.
#ifdef METROLUX_UNDER_THREAD_SANITIZER
constexpr const char* kDeviceOptions = "threads=1";
#else
constexpr const char* kDeviceOptions = nullptr;
#endif

void boundsOfAnalytic(const RTCBoundsFunctionArguments* arguments) {
    Vec3f lower, upper;
    static_cast<const AnalyticShape*>(arguments->geometryUserPtr)->bounds(lower, upper);
    RTCBounds& b = *arguments->bounds_o;
    b.lower_x = lower.x, b.lower_y = lower.y, b.lower_z = lower.z;
    b.upper_x = upper.x, b.upper_y = upper.y, b.upper_z = upper.z;
}

void intersectAnalytic(const RTCIntersectFunctionNArguments* arguments) {
    const unsigned n = arguments->N;
    RTCRayN* const rays = RTCRayHitN_RayN(arguments->rayhit, n);
    RTCHitN* const hits = RTCRayHitN_HitN(arguments->rayhit, n);
    const auto* shape = static_cast<const AnalyticShape*>(arguments->geometryUserPtr);
    for (unsigned i = 0; i < n; ++i) {
        if (!arguments->valid[i]) continue;
        const Ray ray = toRay(rtcGetRayFromRayN(rays, n, i));
        float t = ray.tMax;
        if (!shape->intersect(ray, RTCRayN_tnear(rays, n, i), t, nullptr)) continue;
        RTCRayN_tfar(rays, n, i) = t;
        RTCHitN_geomID(hits, n, i) = arguments->geomID;
        RTCHitN_primID(hits, n, i) = 0;
        RTCHitN_instID(hits, n, i, 0) = arguments->context->instID[0];
        reinterpret_cast<QueryContext*>(arguments->context)->analyticRays[RTCRayN_id(rays, n, i)] = ray;
    }
}

void occludedAnalytic(const RTCOccludedFunctionNArguments* arguments) {
    const unsigned n = arguments->N;
    const auto* shape = static_cast<const AnalyticShape*>(arguments->geometryUserPtr);
    for (unsigned i = 0; i < n; ++i) {
        if (!arguments->valid[i]) continue;
        const Ray ray = toRay(rtcGetRayFromRayN(arguments->ray, n, i));
        float t = ray.tMax;
        if (shape->intersect(ray, RTCRayN_tnear(arguments->ray, n, i), t, nullptr))
            RTCRayN_tfar(arguments->ray, n, i) = -kInfinity;
    }
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
    bool pairs = false;  ///< its meshes are quadrilaterals for Embree (triangle_pairs.h)
};

/// Whether rays are traced one by one: so few are not slower so.
bool oneByOne(size_t count, int packetWidth, Coherence coherence) {
    return count < 4 || packetWidth == 1 || coherence == Coherence::Alone;
}

/// Share of triangles with a partner from which a group is given in pairs. The others have an empty half.
constexpr double kPairedShare = 0.75;

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
    bool hasAnalytic = false;            // of any group
    int packetWidth = 1;                 // the widest that the processor traces as a whole
    std::mutex errorMutex;
    std::string error;  // the first that Embree reported
    bool outOfMemory = false;

    Impl() {
        // Embree's flush-to-zero modes stay off: they would belong in every thread that traces, and results
        // must not depend on the thread.
        device = rtcNewDevice(kDeviceOptions);
        if (!device) {
            const RTCError code = rtcGetDeviceError(nullptr);
            if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
            throw Error("Embree: no device (error {})", static_cast<int>(code));
        }
        rtcSetDeviceErrorFunction(
            device,
            [](void* self, RTCError code, const char* text) {
                auto& impl = *static_cast<Impl*>(self);
                const std::lock_guard lock(impl.errorMutex);
                impl.outOfMemory |= code == RTC_ERROR_OUT_OF_MEMORY;
                if (impl.outOfMemory) return;
                if (impl.error.empty())
                    impl.error = fmt::format("{} (error {})", text, static_cast<int>(code));
            },
            this);
        using Width = std::pair<RTCDeviceProperty, int>;
        for (const auto& [property, width] : {Width{RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED, 4},
                                              Width{RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED, 8},
                                              Width{RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED, 16}})
            if (rtcGetDeviceProperty(device, property)) packetWidth = width;
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
        if (outOfMemory) throw std::bad_alloc();
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

    RTCGeometry newGeometry(const Target& target, bool pairs) {
        if (const TriangleMesh* mesh = target.mesh) {
            RTCGeometry geometry =
                rtcNewGeometry(device, pairs ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
            check("making a mesh");
            setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, sizeof(Vec3f),
                      mesh->positions.size(), mesh->positions);
            if (pairs) {
                void* quadrilaterals =
                    rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                                            4 * sizeof(uint32_t), mesh->primitiveCount());
                check("allocating a mesh");
                writeQuadrilaterals(mesh->indices, static_cast<uint32_t*>(quadrilaterals));
            } else {
                setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t),
                          mesh->primitiveCount(), mesh->indices);
            }
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
    void fill(Group& group, const std::vector<ShapePtr>& shapes, size_t pairFrom) {
        group.scene = rtcNewScene(device);
        check("making a scene");
        rtcSetSceneFlags(group.scene, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(group.scene, RTC_BUILD_QUALITY_HIGH);
        for (const ShapePtr& shape : shapes) {
            group.targets.emplace_back(*shape);
            hasAnalytic |= group.targets.back().analytic != nullptr;
        }
        group.pairs = isBetterInPairs(group.targets, pairFrom);
        for (size_t i = 0; i < shapes.size(); ++i)
            attach(group.scene, newGeometry(group.targets[i], group.pairs), i,
                   fmt::format("attaching shape \"{}\"", shapes[i]->id));
    }

    /// All of a group or nothing: Embree has a tree for each kind of primitive.
    static bool isBetterInPairs(const std::vector<Target>& targets, size_t pairFrom) {
        size_t triangles = 0, paired = 0;
        for (const Target& t : targets)
            if (t.mesh) triangles += t.mesh->primitiveCount();
        if (triangles < pairFrom) return false;
        for (const Target& t : targets)
            if (t.mesh) paired += pairedTriangles(t.mesh->indices);
        return double(paired) >= kPairedShare * double(triangles);
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

    const PlacedGroup* placementOf(const RayHit& hit) const {
        return hit.instance != RayHit::kNone ? &instances[hit.instance - top.targets.size()] : nullptr;
    }
    const Group& groupOf(const PlacedGroup* placed) const { return placed ? *placed->group : top; }
    /// Calls body(mesh, triangle) if a mesh was hit.
    template <class Body>
    void withTriangle(const RayHit& hit, Body&& body) const {
        if (!hit.found()) return;
        const Group& group = groupOf(placementOf(hit));
        const TriangleMesh* mesh = group.targets[hit.geometry].mesh;
        if (!mesh) return;
        const bool second = group.pairs && onSecondTriangle(hit.uv);
        body(*mesh, second && hit.primitive + 1 < mesh->primitiveCount() ? hit.primitive + 1 : hit.primitive);
    }
    /// Ask for the memory that interaction() will read. Two steps, as what a face leads to is known when it
    /// is there.
    void prefetchFace(const RayHit& hit) const {
        withTriangle(hit, [](const TriangleMesh& mesh, uint32_t t) { core::prefetchFace(mesh, t); });
    }
    void prefetchVertices(const RayHit& hit) const {
        withTriangle(hit, [](const TriangleMesh& mesh, uint32_t t) { core::prefetchVertices(mesh, t); });
    }

    /// `analyticRay`: the ray in the space of the group that was hit, for analytic shapes.
    void interaction(const RayHit& hit, const Ray& analyticRay, SurfaceInteraction& si) const {
        const PlacedGroup* placed = placementOf(hit);
        const Group& group = groupOf(placed);
        const Target& target = group.targets[hit.geometry];
        if (const TriangleMesh* mesh = target.mesh) {
            TrianglePoint point{hit.primitive, hit.uv};
            if (group.pairs) point = pointOfQuadrilateral(mesh->indices, hit.primitive, hit.uv);
            mesh->interaction(point.triangle, point.barycentric, si);
        } else {
            // The same call with the same ray as in the traversal: it finds the same hit.
            float t = kInfinity;
            target.analytic->intersect(analyticRay, 0, t, &si);
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
    }
};
static_assert(RayHit::kNone == RTC_INVALID_GEOMETRY_ID);

Intersector::Intersector(const std::vector<ShapePtr>& shapes, const std::vector<Instance>& instances,
                         size_t pairFrom)
    : impl_(std::make_unique<Impl>()) {
    Impl& impl = *impl_;
    impl.keptShapes = shapes;
    impl.fill(impl.top, shapes, pairFrom);
    for (const Instance& instance : instances) {
        const auto [it, isNew] = impl.groups.try_emplace(instance.group.get());
        Group& group = it->second;
        if (isNew) {
            impl.keptGroups.push_back(instance.group);
            impl.fill(group, instance.group->shapes, pairFrom);
            rtcCommitScene(group.scene);
            impl.check("building a shape group");
        }
        impl.attachInstance(instance, group);
    }
    rtcCommitScene(impl.top.scene);
    impl.check("building the scene");
}

Intersector::~Intersector() = default;

bool Intersector::intersect(const Ray& ray, SurfaceInteraction& si) const {
    Ray analyticRay;
    RTCRayHit query;
    bool found;
    {
        const RayTimer timer(&RayCounters::intersectRays);
        found = nearest(impl_->top.scene, ray, query, analyticRay);
    }
    if (RayRecorder* recorder = RayRecorder::active()) recorder->add({ray, false, found});
    if (!found) return false;
    const RTCHit& hit = query.hit;
    impl_->interaction({hit.geomID, hit.primID, hit.instID[0], {hit.u, hit.v}}, analyticRay, si);
    return true;
}

void Intersector::intersect(RayBatch& batch, Coherence coherence) const {
    const size_t n = batch.size();
    batch.hits.resize(n);
    Ray* analyticRays = nullptr;
    if (impl_->hasAnalytic) {
        batch.localRays.resize(n);
        analyticRays = batch.localRays.data();
    }
    const RTCScene scene = impl_->top.scene;
    {
        const RayTimer timer(&RayCounters::intersectRays, n);
        if (oneByOne(n, impl_->packetWidth, coherence)) {
            Ray unused;
            for (size_t i = 0; i < n; ++i) {
                RTCRayHit query;
                nearest(scene, batch.rays[i], query, analyticRays ? analyticRays[i] : unused);
                const RTCHit& hit = query.hit;
                batch.hits[i] = {hit.geomID, hit.primID, hit.instID[0], {hit.u, hit.v}};
                // Such batches are too small for prefetchAfter(); what they hit comes while the next are
                // traced.
                impl_->prefetchFace(batch.hits[i]);
                if (i > 0) impl_->prefetchVertices(batch.hits[i - 1]);
            }
            if (n > 0) impl_->prefetchVertices(batch.hits[n - 1]);
        } else {
            intersectPackets(scene, impl_->packetWidth, coherence, batch, analyticRays);
        }
    }
    if (RayRecorder* recorder = RayRecorder::active()) recorder->add(batch, coherence);
}

void Intersector::interaction(const RayBatch& batch, size_t i, SurfaceInteraction& si) const {
    impl_->interaction(batch.hits[i], impl_->hasAnalytic ? batch.localRays[i] : batch.rays[i], si);
}

void Intersector::prefetchAfter(const RayBatch& batch, size_t i) const {
    constexpr size_t kAhead = 8;
    if (const size_t k = i + 2 * kAhead; k < batch.size()) impl_->prefetchFace(batch.hits[k]);
    if (const size_t k = i + kAhead; k < batch.size()) impl_->prefetchVertices(batch.hits[k]);
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

void Intersector::occluded(OcclusionBatch& batch, Coherence coherence) const {
    const size_t n = batch.size();
    batch.blocked.resize(n);
    const RTCScene scene = impl_->top.scene;
    {
        const RayTimer timer(&RayCounters::shadowRays, n);
        if (oneByOne(n, impl_->packetWidth, coherence))
            for (size_t i = 0; i < n; ++i) batch.blocked[i] = anything(scene, batch.rays[i]);
        else
            occludedPackets(scene, impl_->packetWidth, batch);
    }
    if (RayRecorder* recorder = RayRecorder::active()) recorder->add(batch, coherence);
}

bool Intersector::meets(const Ray& ray) const {
    Ray analyticRay;
    RTCRayHit query;
    const bool found = nearest(impl_->top.scene, ray, query, analyticRay);
    if (RayRecorder* recorder = RayRecorder::active()) recorder->add({ray, false, found});
    return found;
}

int Intersector::packetWidth() const { return impl_->packetWidth; }

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

}  // namespace metrolux::core
