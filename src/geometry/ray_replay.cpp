#include "geometry/ray_replay.h"

#include "base/parallel.h"

#include <algorithm>

namespace metrolux::core {

namespace {

constexpr size_t kRaysInPiece = 16384, kRaysInBatch = 1024;

/// Every third bit of the result is one of the 20 lowest of `x`.
uint64_t spread(uint64_t x) {
    uint64_t result = 0;
    for (int bit = 0; bit < 20; ++bit) result |= (x >> bit & 1) << (3 * bit);
    return result;
}

/// Octant of the direction, then the place of the origin on a Morton curve through the box.
uint64_t placeOf(const Ray& ray, const Vec3f& lower, const Vec3f& upper) {
    uint64_t place = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double size = double(upper[axis]) - double(lower[axis]);
        const double along = size > 0 ? (double(ray.origin[axis]) - double(lower[axis])) / size : 0;
        place |= spread(static_cast<uint64_t>(std::clamp(along, 0.0, 1.0) * 0xfffff)) << axis;
        place |= uint64_t{ray.direction[axis] < 0} << (60 + axis);
    }
    return place;
}

}  // namespace

RayReplay::RayReplay(const Intersector& intersector, const RayRecorder& recorder, Order order)
    : intersector_(intersector) {
    if (order == Order::Sorted) {
        sort(recorder);
        return;
    }
    for (const RecordedThread* thread : recorder.byThread()) take(*thread);
}

void RayReplay::add(Call call, size_t rays) {
    if (pieces_.empty() || pieces_.back().rays >= kRaysInPiece) pieces_.emplace_back();
    pieces_.back().calls.push_back(std::move(call));
    pieces_.back().rays += rays;
}

void RayReplay::addBatch(std::span<const RecordedRay> rays, Coherence coherence) {
    if (rays.front().occlusion)
        add(Together<OcclusionBatch>(rays, coherence), rays.size());
    else
        add(Together<RayBatch>(rays, coherence), rays.size());
}

void RayReplay::take(const RecordedThread& thread) {
    std::span<const RecordedRay> rest = thread.rays;
    for (const RecordedCall& call : thread.calls) {
        const std::span<const RecordedRay> rays = rest.first(call.count);
        rest = rest.subspan(call.count);
        if (!call.batch)
            add(Single{rays.front()}, 1);
        else if (!rays.empty())
            addBatch(rays, call.coherence);
    }
}

void RayReplay::sort(const RayRecorder& recorder) {
    Vec3f lower, upper;
    intersector_.bounds(lower, upper);
    for (const bool occlusion : {false, true}) {
        std::vector<std::pair<uint64_t, RecordedRay>> rays;
        for (const RecordedThread* thread : recorder.byThread())
            for (const RecordedRay& r : thread->rays)
                if (r.occlusion == occlusion) rays.emplace_back(placeOf(r.ray, lower, upper), r);
        std::stable_sort(rays.begin(), rays.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        std::vector<RecordedRay> sorted;
        for (const auto& [place, ray] : rays) sorted.push_back(ray);
        for (std::span<const RecordedRay> rest = sorted; !rest.empty();) {
            const std::span<const RecordedRay> batch = rest.first(std::min(rest.size(), kRaysInBatch));
            rest = rest.subspan(batch.size());
            addBatch(batch, Coherence::None);
        }
    }
}

void RayReplay::run() {
    struct Trace {
        const Intersector& intersector;
        void operator()(Single& s) const {
            const Ray& ray = s.recorded.ray;
            s.hit = s.recorded.occlusion ? intersector.occluded(ray) : intersector.meets(ray);
        }
        void operator()(Together<RayBatch>& t) const { intersector.intersect(t.batch, t.coherence); }
        void operator()(Together<OcclusionBatch>& t) const { intersector.occluded(t.batch, t.coherence); }
    };
    parallelFor(pieces_.size(), [&](size_t i) {
        for (Call& call : pieces_[i].calls) std::visit(Trace{intersector_}, call);
    });
}

size_t RayReplay::different() const {
    struct Count {
        size_t operator()(const Single& s) const { return s.hit != s.recorded.hit; }
        size_t operator()(const Together<RayBatch>& t) const {
            size_t count = 0;
            for (size_t i = 0; i < t.recorded.size(); ++i)
                count += t.batch.hits[i].found() != (t.recorded[i] != 0);
            return count;
        }
        size_t operator()(const Together<OcclusionBatch>& t) const {
            size_t count = 0;
            for (size_t i = 0; i < t.recorded.size(); ++i) count += t.batch.blocked[i] != t.recorded[i];
            return count;
        }
    };
    size_t count = 0;
    for (const Piece& piece : pieces_)
        for (const Call& call : piece.calls) count += std::visit(Count(), call);
    return count;
}

}  // namespace metrolux::core
