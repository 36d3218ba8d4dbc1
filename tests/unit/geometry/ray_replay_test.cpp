#include "geometry/ray_replay.h"

#include "support.h"

namespace metrolux::core {
namespace {

Intersector cubeAndSphere() {
    return {{makeCube(Transform(), false), makeSphere(Transform(), {3, 0, 0}, 1, false)}, {}};
}

Ray randomRay(CounterRng& rng) {
    const Vec3f from = warp::squareToSphere(rng.next2D()) * 5.0f;
    return {from, normalize(warp::squareToSphere(rng.next2D()) * 4.0f - from)};
}

/// Single rays, batches of several sizes (some too small for packets, some empty) and of each coherence.
void trace(const Intersector& scene, uint64_t seed) {
    CounterRng rng(hashKey(seed));
    for (const size_t size : {1, 3, 0, 100, 16, 1000, 7}) {
        RayBatch batch;
        OcclusionBatch shadows;
        for (size_t i = 0; i < size; ++i) {
            batch.rays.push_back(randomRay(rng));
            shadows.rays.push_back(randomRay(rng));
        }
        for (const Coherence coherence : {Coherence::Alone, Coherence::None, Coherence::High}) {
            scene.intersect(batch, coherence);
            SurfaceInteraction si;
            scene.intersect(randomRay(rng), si);
            scene.occluded(randomRay(rng));
            scene.occluded(shadows, coherence);
        }
    }
}
constexpr size_t kRays = 3 * (2 * 1127 + 2 * 7), kCalls = 3 * 7 * 4;

TEST(RayRecorder, RecordsWhatHappensDuringRecord) {
    const Intersector scene = cubeAndSphere();
    trace(scene, 1);  // before: not recorded
    RayRecorder recorder;
    recorder.record([&] { trace(scene, 2); });
    trace(scene, 3);
    EXPECT_EQ(RayRecorder::active(), nullptr);
    ASSERT_EQ(recorder.byThread().size(), 1u);
    const RecordedThread& thread = *recorder.byThread().front();
    EXPECT_EQ(thread.rays.size(), kRays);
    EXPECT_EQ(thread.calls.size(), kCalls);
    size_t batches = 0;
    for (const RecordedCall& call : thread.calls) batches += call.batch;
    EXPECT_EQ(batches, kCalls / 2);
    for (const RecordedRay& r : thread.rays) {
        SurfaceInteraction si;
        EXPECT_EQ(r.hit, r.occlusion ? scene.occluded(r.ray) : scene.intersect(r.ray, si));
    }
}

TEST(RayReplay, AsCalledMakesTheSameCalls) {
    const Intersector scene = cubeAndSphere();
    RayRecorder recorder, replayed;
    recorder.record([&] { trace(scene, 2); });
    RayReplay replay(scene, recorder, RayReplay::Order::AsCalled);
    replayed.record([&] { replay.run(); });
    EXPECT_EQ(replay.different(), 0u);

    const RecordedThread& first = *recorder.byThread().front();
    std::vector<RecordedRay> rays;
    std::vector<RecordedCall> calls;
    for (const RecordedThread* thread : replayed.byThread()) {
        rays.insert(rays.end(), thread->rays.begin(), thread->rays.end());
        calls.insert(calls.end(), thread->calls.begin(), thread->calls.end());
    }
    ASSERT_EQ(rays.size(), kRays);
    for (size_t i = 0; i < kRays; ++i) {
        EXPECT_EQ(rays[i].ray.origin, first.rays[i].ray.origin);
        EXPECT_EQ(rays[i].occlusion, first.rays[i].occlusion);
        EXPECT_EQ(rays[i].hit, first.rays[i].hit);
    }
    size_t k = 0;
    for (const RecordedCall& call : first.calls) {
        if (call.count == 0) continue;
        ASSERT_LT(k, calls.size());
        EXPECT_EQ(calls[k].count, call.count);
        EXPECT_EQ(calls[k].batch, call.batch);
        EXPECT_EQ(calls[k].coherence, call.coherence);
        ++k;
    }
    EXPECT_EQ(k, calls.size());
}

TEST(RayReplay, SortedAsksTheSameInAnotherOrder) {
    const Intersector scene = cubeAndSphere();
    RayRecorder recorder, replayed;
    recorder.record([&] { trace(scene, 2); });
    RayReplay replay(scene, recorder, RayReplay::Order::Sorted);
    replayed.record([&] { replay.run(); });
    EXPECT_EQ(replay.different(), 0u);
    size_t rays = 0;
    double sum = 0, expected = 0;
    for (const RecordedThread* thread : replayed.byThread()) {
        for (const RecordedCall& call : thread->calls) EXPECT_TRUE(call.batch);
        for (const RecordedRay& r : thread->rays) sum += double(r.ray.origin.x) * double(r.ray.direction.y);
        rays += thread->rays.size();
    }
    for (const RecordedRay& r : recorder.byThread().front()->rays)
        expected += double(r.ray.origin.x) * double(r.ray.direction.y);
    EXPECT_EQ(rays, kRays);
    EXPECT_NEAR(sum, expected, 1e-9);
}

TEST(RayReplay, AnotherSceneAnswersOtherwise) {
    const Intersector scene = cubeAndSphere(), empty({}, {});
    RayRecorder recorder;
    recorder.record([&] { trace(scene, 2); });
    size_t hits = 0;
    for (const RecordedRay& r : recorder.byThread().front()->rays) hits += r.hit;
    EXPECT_GT(hits, kRays / 10);
    for (const RayReplay::Order order : {RayReplay::Order::AsCalled, RayReplay::Order::Sorted}) {
        RayReplay replay(empty, recorder, order);
        replay.run();
        EXPECT_EQ(replay.different(), hits);
    }
}

}  // namespace
}  // namespace metrolux::core
