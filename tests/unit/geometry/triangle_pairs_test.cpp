#include "geometry/triangle_pairs.h"

#include "support.h"

#include <array>
#include <limits>

namespace metrolux::core {
namespace {

constexpr size_t kNever = std::numeric_limits<size_t>::max();

/// The triangle with another corner first.
std::array<uint32_t, 3> turned(const std::array<uint32_t, 3>& t, int by) {
    return {t[by % 3], t[(by + 1) % 3], t[(by + 2) % 3]};
}

std::vector<uint32_t> joined(const std::vector<std::array<uint32_t, 3>>& triangles) {
    std::vector<uint32_t> indices;
    for (const auto& t : triangles) indices.insert(indices.end(), t.begin(), t.end());
    return indices;
}

/// What Embree's manual says of a quadrilateral's point: the triangle v0, v1, v3 has its coordinates, v2, v3,
/// v1 has one minus them.
Vec3f embreePoint(const std::vector<Vec3f>& p, const uint32_t* q, const Vec2f& uv) {
    if (uv.x + uv.y <= 1) return p[q[0]] + (p[q[1]] - p[q[0]]) * uv.x + (p[q[3]] - p[q[0]]) * uv.y;
    return p[q[2]] + (p[q[3]] - p[q[2]]) * (1 - uv.x) + (p[q[1]] - p[q[2]]) * (1 - uv.y);
}

TEST(TrianglePairs, PointsAreThoseOfTheTriangles) {
    const std::vector<Vec3f> p{{0, 0, 0}, {2, 0, 0.5f}, {2.5f, 3, 0}, {0, 1, -1}};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const std::vector<uint32_t> indices = joined({turned({0, 1, 3}, i), turned({2, 3, 1}, k)});
            ASSERT_EQ(pairedTriangles(indices), 2u);
            uint32_t q[8];
            writeQuadrilaterals(indices, q);
            EXPECT_EQ(q[0], 0u);
            EXPECT_EQ(q[1], 1u);
            EXPECT_EQ(q[2], 2u);
            EXPECT_EQ(q[3], 3u);
            for (int c = 4; c < 8; ++c) EXPECT_GE(q[c], 4u);  // left out
            for (const Vec2f& uv :
                 {Vec2f(0.2f, 0.5f), Vec2f(0.7f, 0.1f), Vec2f(0.6f, 0.9f), Vec2f(0.8f, 0.3f)}) {
                const TrianglePoint at = pointOfQuadrilateral(indices, 0, uv);
                EXPECT_EQ(at.triangle, uv.x + uv.y > 1 ? 1u : 0u);
                const uint32_t* v = &indices[3 * at.triangle];
                const Vec2f b = at.barycentric;
                expectNear(p[v[0]] * (1 - b.x - b.y) + p[v[1]] * b.x + p[v[2]] * b.y, embreePoint(p, q, uv),
                           1e-6f, "point");
            }
        }
}

TEST(TrianglePairs, OnlyOppositeEdgesOfSuccessiveTriangles) {
    EXPECT_EQ(pairedTriangles({}), 0u);
    EXPECT_EQ(pairedTriangles(joined({{0, 1, 2}})), 0u);
    EXPECT_EQ(pairedTriangles(joined({{0, 1, 2}, {3, 4, 5}})), 0u);             // nothing in common
    EXPECT_EQ(pairedTriangles(joined({{0, 1, 2}, {2, 3, 4}})), 0u);             // a vertex
    EXPECT_EQ(pairedTriangles(joined({{0, 1, 2}, {0, 1, 3}})), 0u);             // one is turned over
    EXPECT_EQ(pairedTriangles(joined({{0, 1, 2}, {5, 6, 7}, {0, 2, 3}})), 0u);  // not successive
    EXPECT_EQ(pairedTriangles(joined({{0, 1, 2}, {0, 2, 3}})), 2u);
    EXPECT_EQ(pairedTriangles(joined({{0, 1, 2}, {0, 2, 3}, {0, 3, 4}})), 2u);  // a fan: each has one partner
    EXPECT_EQ(pairedTriangles(joined({{7, 8, 9}, {0, 1, 2}, {0, 2, 3}})), 2u);
}

TEST(TrianglePairs, ATriangleAloneIsItself) {
    const std::vector<uint32_t> indices = joined({{0, 1, 2}, {3, 4, 5}});
    uint32_t q[8];
    writeQuadrilaterals(indices, q);
    EXPECT_TRUE(std::equal(q, q + 4, std::array{0u, 1u, 2u, 2u}.begin()));
    // Rounding may take a point over the edge.
    for (const uint32_t triangle : {0u, 1u}) {
        const Vec2f over(0.5f, 0.5000002f);
        ASSERT_TRUE(onSecondTriangle(over));
        const TrianglePoint at = pointOfQuadrilateral(indices, triangle, over);
        EXPECT_EQ(at.triangle, triangle);
        EXPECT_EQ(at.barycentric, over);
    }
}

/// A closed, bumpy torus: most cells are pairs, in all ways of writing them; in some the triangles are far
/// apart in the list, or one is turned over.
std::shared_ptr<TriangleMesh> bumpyTorus(double share = 0.85) {
    constexpr uint32_t kAround = 40, kAcross = 24;
    auto mesh = std::make_shared<TriangleMesh>();
    CounterRng rng(hashKey(1));
    for (uint32_t i = 0; i < kAround; ++i)
        for (uint32_t k = 0; k < kAcross; ++k) {
            const double a = 2 * kPi * i / kAround, b = 2 * kPi * k / kAcross;
            const double r = 0.7 + 0.1 * rng.nextDouble(), ring = 2 + r * std::cos(b);
            mesh->positions.push_back({static_cast<float>(ring * std::cos(a)),
                                       static_cast<float>(ring * std::sin(a)),
                                       static_cast<float>(r * std::sin(b))});
        }
    std::vector<std::array<uint32_t, 3>> triangles, apart;
    const auto any = [&] { return static_cast<int>(3 * rng.nextDouble()); };
    for (uint32_t i = 0; i < kAround; ++i)
        for (uint32_t k = 0; k < kAcross; ++k) {
            const uint32_t i1 = (i + 1) % kAround, k1 = (k + 1) % kAcross;
            const uint32_t v[4] = {i * kAcross + k, i1 * kAcross + k, i1 * kAcross + k1, i * kAcross + k1};
            const int from = rng.next1D() < 0.5f ? 0 : 1;  // either diagonal
            std::array<uint32_t, 3> first = turned({v[from], v[from + 1], v[(from + 3) % 4]}, any()),
                                    second = turned({v[from + 2], v[(from + 3) % 4], v[from + 1]}, any());
            triangles.push_back(first);
            if (rng.nextDouble() < share) {
                triangles.push_back(second);
            } else {
                if (rng.next1D() < 0.5f) std::swap(second[0], second[1]);
                apart.push_back(second);
            }
        }
    triangles.insert(triangles.end(), apart.begin(), apart.end());
    mesh->indices = joined(triangles);
    mesh->finalize();
    return mesh;
}

/// Whether Embree has pairs: only they have points beyond the triangle.
bool hasPairs(const Intersector& scene) {
    RayBatch batch;
    CounterRng rng(hashKey(2));
    for (int i = 0; i < 1000; ++i)
        batch.rays.push_back({{4 * rng.next1D() - 2, 4 * rng.next1D() - 2, 5}, {0, 0, -1}});
    scene.intersect(batch);
    size_t beyond = 0;
    for (const RayHit& hit : batch.hits) beyond += hit.found() && hit.uv.x + hit.uv.y > 1.01f;
    return beyond > 0;
}

TEST(TrianglePairs, OfLargeGroupsThatHaveEnough) {
    const auto mesh = bumpyTorus();
    const size_t n = mesh->primitiveCount();
    EXPECT_TRUE(hasPairs({{mesh}, {}, n}));
    EXPECT_FALSE(hasPairs({{mesh}, {}, n + 1}));
    EXPECT_FALSE(hasPairs({{mesh}, {}}));  // too few to be worth it
    const auto few = bumpyTorus(0.5);
    ASSERT_LT(double(pairedTriangles(few->indices)), 0.7 * double(n));
    EXPECT_FALSE(hasPairs({{few}, {}, 0}));
    // The shapes of a group count together.
    EXPECT_TRUE(hasPairs({{mesh, makeSphere(Transform(), {9, 9, 9}, 1, false), mesh}, {}, 2 * n}));
}

/// Rays find the same points on pairs as on triangles, whole rays and in packets, placed and instanced.
TEST(TrianglePairs, RaysFindTheSamePoints) {
    const auto mesh = bumpyTorus();
    const size_t paired = pairedTriangles(mesh->indices);
    ASSERT_GT(paired, mesh->primitiveCount() * 4 / 5);
    ASSERT_LT(paired, mesh->primitiveCount());
    auto group = std::make_shared<ShapeGroup>();
    group->shapes = {mesh};
    const std::vector<Instance> instances{{group, similarity()}, {group, Transform::translate({0, 0, -4})}};
    const std::vector<ShapePtr> shapes{mesh, makeSphere(Transform(), {3, 3, 3}, 1, false)};
    const Intersector triangles(shapes, instances, kNever), pairs(shapes, instances, 0);
    ASSERT_TRUE(hasPairs(pairs));
    ASSERT_FALSE(hasPairs(triangles));

    CounterRng rng(hashKey(3));
    RayBatch batch;
    OcclusionBatch shadows;
    for (int i = 0; i < 20000; ++i) {
        const Vec3f from = warp::squareToSphere(rng.next2D()) * 9.0f,
                    to = warp::squareToSphere(rng.next2D()) * 4.0f;
        batch.rays.push_back({from, normalize(to - from)});
        shadows.rays.push_back({from, normalize(to - from), 9 * rng.next1D()});
    }
    pairs.intersect(batch);
    pairs.occluded(shadows);
    size_t hits = 0, second = 0, nearEdges = 0;
    for (size_t i = 0; i < batch.size(); ++i) {
        SurfaceInteraction a, b, c;
        ASSERT_EQ(triangles.intersect(batch.rays[i], a), pairs.intersect(batch.rays[i], b));
        ASSERT_EQ(a.shape != nullptr, batch.hits[i].found());
        EXPECT_EQ(triangles.occluded(shadows.rays[i]), pairs.occluded(shadows.rays[i]));
        EXPECT_EQ(triangles.occluded(shadows.rays[i]), shadows.blocked[i] != 0);
        if (!a.shape) continue;
        pairs.interaction(batch, i, c);
        ++hits;
        second += onSecondTriangle(batch.hits[i].uv);
        const float smallest =
            std::min(1 - a.barycentric.x - a.barycentric.y, std::min(a.barycentric.x, a.barycentric.y));
        const bool atEdge = smallest < 1e-4f;
        nearEdges += atEdge;
        for (const SurfaceInteraction& si : {b, c}) {
            EXPECT_EQ(si.shape, a.shape);
            expectNear(si.p, a.p, 2e-5f, "p");
            if (a.shape != mesh.get() || atEdge) continue;
            EXPECT_EQ(si.primitive, a.primitive);
            EXPECT_NEAR(si.barycentric.x, a.barycentric.x, 1e-4f);
            EXPECT_NEAR(si.barycentric.y, a.barycentric.y, 1e-4f);
            EXPECT_EQ(si.ng, a.ng);
        }
    }
    EXPECT_GT(hits, 8000u);
    EXPECT_GT(second, 2000u);
    EXPECT_LT(nearEdges, hits / 4);
}

/// No ray leaves a closed surface between two triangles: aimed at corners, edges and diagonals from within.
TEST(TrianglePairs, NothingLeaksThroughEdges) {
    const auto mesh = bumpyTorus();
    const Intersector pairs({mesh}, {}, 0);
    CounterRng rng(hashKey(4));
    RayBatch batch;
    for (size_t t = 0; t < mesh->primitiveCount(); ++t)
        for (int corner = 0; corner < 3; ++corner) {
            const Vec3f &a = mesh->positions[mesh->indices[3 * t + corner]],
                        &b = mesh->positions[mesh->indices[3 * t + (corner + 1) % 3]];
            for (const float s : {0.0f, 0.5f, rng.next1D(), rng.next1D()}) {
                const Vec3f target = a + (b - a) * s;
                // The axis of the tube.
                const Vec3f from = normalize(Vec3f(target.x, target.y, 0)) * 2.0f;
                batch.rays.push_back({from, normalize(target - from)});
            }
        }
    pairs.intersect(batch);
    for (size_t i = 0; i < batch.size(); ++i) {
        SurfaceInteraction si;
        EXPECT_TRUE(pairs.intersect(batch.rays[i], si)) << i;
        EXPECT_TRUE(batch.hits[i].found()) << i;
        EXPECT_TRUE(pairs.occluded(batch.rays[i])) << i;
    }
}

}  // namespace
}  // namespace metrolux::core
