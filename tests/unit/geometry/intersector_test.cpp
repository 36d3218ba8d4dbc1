#include "geometry/intersector.h"

#include "support.h"

#include <tbb/parallel_for.h>

namespace metrolux::core {
namespace {

TEST(Intersector, EmptySceneHitsNothing) {
    const Intersector scene({}, {});
    SurfaceInteraction si;
    EXPECT_FALSE(scene.intersect({{0, 0, 0}, {0, 0, 1}}, si));
    EXPECT_FALSE(scene.occluded({{0, 0, 0}, {0, 0, 1}}));
    Vec3f lower, upper;
    scene.bounds(lower, upper);
    expectNear(lower, upper, 0, "bounds");
}

/// Each ray of a batch gets the answer that it gets alone, to the bit: meshes and analytic shapes, placed and
/// instanced, in triangles and in pairs of them; packets that are full and not, and batches too small for
/// packets.
TEST(Intersector, BatchesGiveTheAnswersOfSingleRays) {
    auto group = std::make_shared<ShapeGroup>();
    group->shapes = {makeSphere(Transform(), {0, 0, 0}, 0.8f, false), makeRectangle(similarity(), false)};
    const std::vector<ShapePtr> placed{makeSphere(Transform(), {2, 0, 0}, 1, false),
                                       makeDisk(Transform::translate({-2, 0, 0}), false),
                                       makeCylinder(Transform(), {0, 2, -1}, {0, 2, 1}, 0.5f, false),
                                       makeCube(Transform::translate({0, -2, 0}), false)};
    std::vector<Instance> instances;
    for (int i = 0; i < 5; ++i)
        instances.push_back(
            {group, Transform::translate({0, 0, 2.0f * static_cast<float>(i) - 4}) * similarity() *
                        Transform::scale({1, 1, 1.0f + static_cast<float>(i)})});
    const std::vector<ShapePtr> cube{makeCube(Transform(), false)};
    const Intersector scenes[] = {{placed, instances}, {cube, {}}, {placed, instances, 0}, {cube, {}, 0}};
    for (const Intersector& scene : scenes)
        for (const size_t count : {0, 1, 3, 4, 16, 17, 35, 1000}) {
            CounterRng rng(hashKey(count));
            RayBatch batch;
            OcclusionBatch shadows;
            for (size_t i = 0; i < count; ++i) {
                const Vec3f from = warp::squareToSphere(rng.next2D()) * 6.0f;
                const Vec3f to = warp::squareToSphere(rng.next2D()) * 2.5f;
                batch.rays.push_back({from, normalize(to - from)});
                shadows.rays.push_back({from, normalize(to - from), 10 * rng.next1D()});
            }
            for (const Coherence coherence : {Coherence::Alone, Coherence::None, Coherence::High}) {
                const RayStatistics before = Intersector::statistics();
                scene.intersect(batch, coherence);
                EXPECT_EQ((Intersector::statistics() - before).intersectRays, count);
                ASSERT_EQ(batch.hits.size(), count);
                size_t hits = 0;
                for (size_t i = 0; i < count; ++i) {
                    SurfaceInteraction alone, together;
                    ASSERT_EQ(scene.intersect(batch.rays[i], alone), batch.hits[i].found());
                    if (!batch.hits[i].found()) continue;
                    ++hits;
                    scene.interaction(batch, i, together);
                    EXPECT_EQ(alone.shape, together.shape);
                    EXPECT_EQ(alone.placement, together.placement);
                    EXPECT_EQ(alone.primitive, together.primitive);
                    EXPECT_EQ(alone.p, together.p);
                    EXPECT_EQ(alone.ng, together.ng);
                    EXPECT_EQ(alone.s, together.s);
                    EXPECT_EQ(alone.uv, together.uv);
                }
                if (count == 1000) {
                    EXPECT_TRUE(hits > 100 && hits < 900) << hits;
                }
            }
            for (const Coherence coherence : {Coherence::Alone, Coherence::None}) {
                scene.occluded(shadows, coherence);
                ASSERT_EQ(shadows.blocked.size(), count);
                for (size_t i = 0; i < count; ++i)
                    EXPECT_EQ(scene.occluded(shadows.rays[i]), shadows.blocked[i] != 0);
            }
        }
}

TEST(Intersector, FindsTheNearestOfMixedShapes) {
    std::vector<ShapePtr> shapes;
    for (int i = 0; i < 6; ++i) {
        const Vec3f offset(0, 0, -3.0f * static_cast<float>(i));
        if (i % 2)
            shapes.push_back(makeSphere(Transform::translate(offset), Vec3f(0.0f), 1, false));
        else
            shapes.push_back(makeCube(Transform::translate(offset), false));
    }
    const Intersector scene(shapes, {});
    for (size_t i = 0; i < shapes.size(); ++i) {
        const float z = -3.0f * static_cast<float>(i) + 1.2f;
        SurfaceInteraction si;
        ASSERT_TRUE(scene.intersect({{0.1f, 0.2f, z}, {0, 0, -1}}, si));
        EXPECT_EQ(si.shape, shapes[i].get());
        EXPECT_FALSE(scene.occluded({{0.1f, 0.2f, z}, {0, 0, -1}, 0.15f}));
        EXPECT_TRUE(scene.occluded({{0.1f, 0.2f, z}, {0, 0, -1}, 0.25f}));
    }
    Vec3f lower, upper;
    scene.bounds(lower, upper);
    expectNear(lower, {-1, -1, -16}, 1e-4f, "lower");
    expectNear(upper, {1, 1, 1}, 1e-4f, "upper");
}

/// An instance looks the same as the shape that was placed directly.
TEST(Intersector, InstancesEqualPlacedShapes) {
    const Transform maps[] = {Transform(), similarity(), similarity() * Transform::scale({1, 2, 0.5f}),
                              Transform::translate({3, 0, 0}) * Transform::scale({-1, 1, 1})};
    for (const Transform& map : maps) {
        auto group = std::make_shared<ShapeGroup>();
        group->shapes = {makeCube(Transform::translate({2, 0, 0}), false),
                         makeDisk(Transform::translate({-2, 0, 0}), false),
                         makeSphere(Transform(), {0, 0, 0}, 0.5f, false)};
        const Intersector instanced({}, {{group, map}});
        const Intersector placed({makeCube(map * Transform::translate({2, 0, 0}), false),
                                  makeDisk(map * Transform::translate({-2, 0, 0}), false)},
                                 {});
        CounterRng rng(hashKey(21));
        int both = 0;
        for (int i = 0; i < 3000; ++i) {
            const Vec3f target =
                map.point(Vec3f(rng.next1D() * 6 - 3, rng.next1D() * 2 - 1, rng.next1D() * 2 - 1));
            const Vec3f d = warp::squareToSphere(rng.next2D());
            const Ray ray{target - d * 20.0f, d};
            SurfaceInteraction a, b;
            if (!instanced.intersect(ray, a) || a.shape == group->shapes[2].get() ||
                !placed.intersect(ray, b))
                continue;
            if ((a.p - b.p).length() > 1e-3f) continue;  // the sphere, or an edge
            ++both;
            expectNear(a.ng, b.ng, 1e-4f, "ng");
            expectNear(a.ns, b.ns, 1e-4f, "ns");
            EXPECT_LE((a.uv - b.uv).length(), 1e-3f);
            EXPECT_LE((partials(a).dpdu - partials(b).dpdu).length(), 1e-2f * partials(b).dpdu.length());
            EXPECT_LE((partials(a).dpdv - partials(b).dpdv).length(), 1e-2f * partials(b).dpdv.length());
            EXPECT_TRUE(a.placement && !b.placement);
            checkFrame(a);
            EXPECT_TRUE(a.shape == group->shapes[0].get() || a.shape == group->shapes[1].get());
            EXPECT_TRUE(instanced.occluded(ray));
        }
        EXPECT_GT(both, 500);
    }
}

TEST(Intersector, OneGroupInManyPlaces) {
    auto group = std::make_shared<ShapeGroup>();
    group->shapes = {makeSphere(Transform(), {0, 0, 0}, 1, false)};
    std::vector<Instance> instances;
    for (int i = 0; i < 20; ++i)
        instances.push_back({group, Transform::translate({5.0f * static_cast<float>(i), 0, 0})});
    const Intersector scene({makeRectangle(Transform::translate({0, 0, -50}), false)}, instances);
    for (int i = 0; i < 20; ++i) {
        const float x = 5.0f * static_cast<float>(i);
        SurfaceInteraction si;
        ASSERT_TRUE(scene.intersect({{x, 0, 10}, {0, 0, -1}}, si));
        expectNear(si.p, {x, 0, 1}, 1e-5f, "p");
        EXPECT_EQ(si.shape, group->shapes[0].get());
    }
}

TEST(Intersector, CountsRaysOfAllThreads) {
    const Intersector scene({makeSphere(Transform(), {0, 0, 0}, 1, false)}, {});
    const RayStatistics before = Intersector::statistics();
    constexpr int kTasks = 64, kRays = 1000;
    tbb::parallel_for(0, kTasks, [&](int) {
        SurfaceInteraction si;
        for (int i = 0; i < kRays; ++i) {
            scene.intersect({{0, 0, 5}, {0, 0, -1}}, si);
            if (i % 2) scene.occluded({{0, 0, 5}, {0, 0, -1}});
        }
    });
    const RayStatistics statistics = Intersector::statistics() - before;
    EXPECT_EQ(statistics.intersectRays, uint64_t(kTasks * kRays));
    EXPECT_EQ(statistics.shadowRays, uint64_t(kTasks * kRays / 2));
    EXPECT_GT(statistics.secondsInEmbree, 0);
    EXPECT_LT(statistics.secondsInEmbree, 10);
}

}  // namespace
}  // namespace metrolux::core
