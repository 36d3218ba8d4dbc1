#include "spatial/vertex_grid.h"

#include "base/rng.h"
#include "base/warp.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// Something that has a position among other things.
struct Thing {
    double before = 0;
    Vec3f position{0.0f};
    int after = 0;
};
std::vector<Thing> things(const std::vector<Vec3f>& points) {
    std::vector<Thing> result(points.size());
    for (size_t i = 0; i < points.size(); ++i) result[i].position = points[i];
    return result;
}
PointSpan positionsOf(const std::vector<Thing>& things) {
    return {std::span(things), [](const Thing& t) -> const Vec3f& { return t.position; }};
}

/// Compares all queries with a scan of all points; each index must come once.
void expectSameAsBruteForce(const std::vector<Vec3f>& points, float radius,
                            const std::vector<Vec3f>& queries) {
    VertexGrid grid, ofPoints;
    grid.build(positionsOf(things(points)), radius);
    ofPoints.build(points, radius);
    EXPECT_EQ(grid.radius(), radius);
    std::vector<int> visits(points.size());
    for (const Vec3f& q : queries) {
        std::fill(visits.begin(), visits.end(), 0);
        grid.query(q, [&](uint32_t index) {
            ASSERT_LT(index, points.size());
            ++visits[index];
        });
        for (size_t i = 0; i < points.size(); ++i) {
            const bool inside = lengthSquared(points[i] - q) <= radius * radius;
            ASSERT_EQ(visits[i], inside ? 1 : 0)
                << "radius " << radius << " query (" << q.x << ", " << q.y << ", " << q.z << ") point " << i;
        }
        const bool any = std::find(visits.begin(), visits.end(), 1) != visits.end();
        ASSERT_EQ(grid.anyWithin(q), any);
        ASSERT_EQ(ofPoints.anyWithin(q), any);
    }
}

std::vector<Vec3f> randomPoints(int n, const Vec3f& center, float extent, uint64_t seed) {
    CounterRng rng(seed);
    std::vector<Vec3f> points;
    for (int i = 0; i < n; ++i)
        points.push_back(center +
                         Vec3f(rng.next1D() - 0.5f, rng.next1D() - 0.5f, rng.next1D() - 0.5f) * extent);
    return points;
}

TEST(VertexGrid, FindsWhatAScanFindsForRadiiOfAllSizes) {
    const std::vector<Vec3f> points = randomPoints(1500, {0, 0, 0}, 2, 1);
    std::vector<Vec3f> queries = randomPoints(60, {0, 0, 0}, 2.2f, 2);
    queries.insert(queries.end(), points.begin(), points.begin() + 60);
    for (const float radius : {1e-20f, 1e-6f, 1e-3f, 0.02f, 0.1f, 0.5f, 3.0f, 1e3f, 1e10f})
        expectSameAsBruteForce(points, radius, queries);
}

TEST(VertexGrid, ClustersAndCoincidingPointsAreAllVisited) {
    std::vector<Vec3f> points;
    for (int cluster = 0; cluster < 5; ++cluster) {
        const std::vector<Vec3f> c =
            randomPoints(200, Vec3f(float(cluster) * 10 - 20, 0, -3), 1e-3f, 10 + cluster);
        points.insert(points.end(), c.begin(), c.end());
    }
    points.insert(points.end(), 300, Vec3f(1, 2, 3));
    std::vector<Vec3f> queries(points.begin(), points.begin() + 40);
    queries.push_back({1, 2, 3});
    for (const float radius : {1e-4f, 1e-3f, 10.0f}) expectSameAsBruteForce(points, radius, queries);
}

TEST(VertexGrid, PlanesAndCellBordersNeedNoLuck) {
    // Points on the borders of cells of width 2 r (1 + 1e-6), and on both sides of zero.
    std::vector<Vec3f> points;
    for (int x = -6; x <= 6; ++x)
        for (int y = -6; y <= 6; ++y)
            for (const float z : {-0.0f, 0.0f, -1e-7f, 0.5f})
                points.push_back({0.25f * float(x), 0.25f * float(y), z});
    for (const float radius : {0.125f, 0.25f, 0.5f}) expectSameAsBruteForce(points, radius, points);
}

TEST(VertexGrid, WorksFarFromTheOrigin) {
    for (const Vec3f& center : {Vec3f(1e6f, -1e6f, 1e6f), Vec3f(-1e6f, 0, 3), Vec3f(1e9f, 1e9f, -1e9f)}) {
        const float ulp = std::nextafter(std::abs(center.x), kInfinity) - std::abs(center.x);
        const std::vector<Vec3f> points = randomPoints(800, center, 40 * ulp, 20);
        std::vector<Vec3f> queries(points.begin(), points.begin() + 80);
        queries.push_back(center);
        for (const float radius : {1e-4f * ulp, 0.5f * ulp, ulp, 3.3f * ulp, 100 * ulp})
            expectSameAsBruteForce(points, radius, queries);
    }
}

TEST(VertexGrid, OrderDependsOnTheVerticesOnly) {
    const std::vector<Vec3f> points = randomPoints(500, {0, 0, 0}, 1, 30);
    VertexGrid a, b;
    a.build(points, 0.3f);
    b.build(randomPoints(9000, {0, 0, 0}, 5, 31), 0.01f);  // built twice: nothing of the first remains
    b.build(points, 0.3f);
    std::vector<uint32_t> first, second;
    a.query({0, 0, 0}, [&](uint32_t i) { first.push_back(i); });
    b.query({0, 0, 0}, [&](uint32_t i) { second.push_back(i); });
    EXPECT_GT(first.size(), 20u);
    EXPECT_EQ(first, second);
}

TEST(VertexGrid, EmptyAndSingle) {
    VertexGrid grid;
    int visits = 0;
    grid.query({0, 0, 0}, [&](uint32_t) { ++visits; });
    grid.build(std::vector<Vec3f>(), 1);
    grid.build(positionsOf({}), 1);
    grid.query({0, 0, 0}, [&](uint32_t) { ++visits; });
    EXPECT_EQ(visits, 0);
    grid.build(std::vector<Vec3f>{{5, 5, 5}}, 1);
    grid.query({5, 5, 4}, [&](uint32_t i) { visits += i == 0; });
    EXPECT_EQ(visits, 1);
    grid.clear();
    grid.query({5, 5, 4}, [&](uint32_t) { ++visits; });
    EXPECT_EQ(visits, 1);
}

}  // namespace
}  // namespace metrolux::core
