#include "image/hilbert_order.h"
#include "sampling/streams.h"
#include "support/glass_scene.h"
#include "transport/connect.h"
#include "transport/eye_pass.h"
#include "transport/light_subpath_pass.h"
#include "transport/subpath.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

/// The eye vertices of the glass scene, and what a pass over light subpaths needs besides.
struct EyesOfGlassScene {
    explicit EyesOfGlassScene(float radius) {
        const Strategies strategies = Strategies::bidirectional(1, 0.1);
        EyePass{*scene, limits, strategies, nonFinite, 7, 0}.run(pixels, film, eyes);
        grid.build(positionsOf(eyes.all()), radius);
    }
    LightSubpathPass pass(const Strategies& strategies) {
        return {*scene, limits, strategies, eyes, grid, nonFinite};
    }
    std::shared_ptr<Scene> scene = test::glassScene();
    PathLimits limits = scene->parts().limits;
    Film film = test::gaussianFilm(*scene);
    std::vector<uint32_t> pixels = hilbertOrder(film.width(), film.height());
    EyeVertices eyes;
    VertexGrid grid;
    NonFiniteCounts nonFinite;
};

TEST(EyePass, KeepsTheVerticesOfEachSubpathTogether) {
    const EyesOfGlassScene s(0.1f);
    ASSERT_EQ(s.eyes.subpathCount(), s.pixels.size());
    size_t sum = 0;
    for (size_t i = 0; i < s.pixels.size(); ++i) {
        int depth = 0;
        for (const Vertex& v : s.eyes.subpath(i)) {
            EXPECT_EQ(v.pixel, s.pixels[i]);
            EXPECT_GT(v.depth, depth);
            EXPECT_LT(v.depth, 6);  // at the limit nothing can be joined
            EXPECT_TRUE(v.hasSmoothLobe());
            EXPECT_NEAR(v.toPrevious.length(), 1, 1e-5f);
            depth = v.depth;
            ++sum;
        }
    }
    EXPECT_EQ(sum, s.eyes.all().size());
    EXPECT_GT(sum, s.pixels.size() / 3);
    EXPECT_GE(s.eyes.memoryBytes(), sum * sizeof(Vertex));
}

/// The counts of the strategies say what a pass does.
TEST(EyePass, DoesWhatHasACount) {
    const EyesOfGlassScene s(0.1f);
    const auto image = [&](const Strategies& strategies, size_t& vertices) {
        Film film = test::gaussianFilm(*s.scene);
        EyeVertices eyes;
        NonFiniteCounts nonFinite;
        EyePass{*s.scene, s.limits, strategies, nonFinite, 7, 0}.run(s.pixels, film, eyes);
        film.endPass();
        const std::vector<float> rgb = film.image();
        double sum = 0;
        for (const float x : rgb) sum += x;
        vertices = eyes.all().size();
        return sum;
    };
    size_t vertices = 0;
    EXPECT_EQ(image({.connect = 1}, vertices), 0);
    EXPECT_EQ(vertices, s.eyes.all().size());
    const double hit = image({.hit = 1}, vertices);
    EXPECT_EQ(vertices, 0u);
    const double nee = image({.nee = 1}, vertices);
    EXPECT_EQ(vertices, 0u);
    const double both = image({.hit = 1, .nee = 1, .merge = 1}, vertices);
    EXPECT_EQ(vertices, s.eyes.all().size());
    EXPECT_GT(hit, 0);
    EXPECT_GT(nee, 0);
    EXPECT_NE(both, hit + nee);  // they share paths, and weights
    image(Strategies::photonMapping(), vertices);
    EXPECT_GT(vertices, 0u);
    EXPECT_LE(vertices, s.pixels.size());  // one for each subpath
}

TEST(LightSubpathPass, IsAFunctionOfItsStream) {
    EyesOfGlassScene s(0.1f);
    const Strategies strategies = Strategies::bidirectional(1, 0.1);
    const LightSubpathPass pass = s.pass(strategies);
    SplatList first, second;
    int visible = 0;
    for (int i = 0; i < 300; ++i) {
        IndependentStream a(hashKey(i)), b(hashKey(i));
        b.next2D();
        pass.evaluate({&a, &first});
        pass.evaluate({&b, &second});  // entered elsewhere, cleared by itself
        ASSERT_EQ(first.pixels.size(), second.pixels.size());
        ASSERT_EQ(first.film.size(), second.film.size());
        ASSERT_EQ(first.size(), second.size());
        visible += !first.empty();
    }
    EXPECT_GT(visible, 30);
}

TEST(LightSubpathPass, DoesWhatHasACount) {
    EyesOfGlassScene s(0.25f);
    const auto found = [&](const Strategies& strategies) {
        const LightSubpathPass pass = s.pass(strategies);
        std::array<size_t, 2> sum{};  // on pixels, on the film
        SplatList splats;
        for (int i = 0; i < 300; ++i) {
            IndependentStream stream(hashKey(i));
            pass.evaluate({&stream, &splats});
            sum[0] += splats.pixels.size();
            sum[1] += splats.film.size();
        }
        return sum;
    };
    const auto nothing = found({.hit = 1, .nee = 1});
    EXPECT_EQ(nothing[0] + nothing[1], 0u);
    const auto splats = found({.splat = 1}), connections = found({.connect = 1}),
               merges = found({.merge = 1});
    EXPECT_EQ(splats[0], 0u);
    EXPECT_GT(splats[1], 0u);
    EXPECT_GT(connections[0], 0u);
    EXPECT_EQ(connections[1], 0u);
    EXPECT_GT(merges[0], 0u);
    EXPECT_EQ(merges[1], 0u);
    const auto all = found({.connect = 1, .splat = 1, .merge = 1});
    EXPECT_EQ(all[0], connections[0] + merges[0]);
    EXPECT_EQ(all[1], splats[1]);
}

/// Merging finds each eye vertex within the radius, once.
TEST(LightSubpathPass, MergesWithAllThatAScanFinds) {
    EyesOfGlassScene s(0.25f);
    const Strategies strategies{.merge = 0.1};
    const LightSubpathPass pass = s.pass(strategies);
    size_t sum = 0;
    for (int i = 0; i < 200; ++i) {
        IndependentStream stream(hashKey(i));
        SplatList splats;
        std::vector<Vec3f> trail;
        pass.evaluate({&stream, &splats, nullptr, &trail});
        class Scan final : public SubpathVisitor {
          public:
            explicit Scan(const LightSubpathPass& pass) : pass_(pass) {}
            bool surface(const Vertex& v) override {
                const float r = pass_.grid.radius();
                for (const Vertex& eye : pass_.eyes.all()) {
                    if (!v.hasSmoothLobe() || (eye.si.p - v.si.p).length2() > r * r) continue;
                    if (v.depth + eye.depth > pass_.limits.maxDepth) continue;
                    const Rgb value =
                        mergeVertices(pass_.strategies, v, eye, 1.0 / (double(kPi) * r * r)).value;
                    if (!isBlack(value)) found.push_back({double(eye.pixel), value.x, value.y, value.z});
                }
                return v.depth + 1 < pass_.limits.maxDepth;
            }
            std::vector<std::array<double, 4>> found;

          private:
            const LightSubpathPass& pass_;
        } scan(pass);
        traceLightSubpath(pass.scene, stream, pass.limits, pass.strategies, scan);
        std::vector<std::array<double, 4>> found;
        for (const auto& splat : splats.pixels)
            found.push_back({double(splat.pixel), splat.value.x, splat.value.y, splat.value.z});
        std::sort(found.begin(), found.end());  // the grid has an order of its own
        std::sort(scan.found.begin(), scan.found.end());
        ASSERT_EQ(found, scan.found) << i;
        sum += found.size();
    }
    EXPECT_GT(sum, 200u);
}

class MergeTest : public ::testing::Test {
  protected:
    Vertex vertex(const Vec3f& normal, const Vec3f& toPrevious) const {
        Vertex v;
        v.si.shape = floor_.get();
        v.si.ng = v.si.ns = normal;
        v.si.s = Frame::fromNormal(normal).s;
        v.toPrevious = normalize(toPrevious);
        v.throughput = Rgb(1.0f);
        v.distanceToPrevious = 1;
        v.mis = {1, 1, 1};
        v.depth = 1;
        return v;
    }
    MergeTest() { floor_->bsdf = test::diffuse(0.8f); }
    ShapePtr floor_ = test::rectangle({0, 0, 0}, {0, 1, 0}, 1, 1);
    Strategies strategies_ = Strategies::bidirectional(1, 0.1);
};

TEST_F(MergeTest, RefusesTheOtherSideOfAWallAndSharpCorners) {
    const Vertex eye = vertex({0, 1, 0}, {0.3f, 1, 0});
    EXPECT_GT(mergeVertices(strategies_, vertex({0, 1, 0}, {-0.3f, 1, 0}), eye, 1).value.x, 0);
    EXPECT_EQ(mergeVertices(strategies_, vertex({0, -1, 0}, {-0.3f, -1, 0}), eye, 1).value, Rgb(0.0f));
    EXPECT_EQ(mergeVertices(strategies_, vertex({1, 0, 0}, {1, 0.3f, 0}), eye, 1).value, Rgb(0.0f));
    // Curved surfaces go on.
    EXPECT_GT(mergeVertices(strategies_, vertex(normalize(Vec3f(0.3f, 1, 0)), {-0.3f, 1, 0}), eye, 1).value.x,
              0);
}

TEST_F(MergeTest, IsTheReflectanceOverPiPerDisk) {
    const Vertex eye = vertex({0, 1, 0}, {0, 1, 0}), light = vertex({0, 1, 0}, {-1, 1, 0});
    const double inverseDisk = 7;
    const double weight =
        mergeWeight(strategies_, light.mis, eye.mis, std::cos(kPi / 4) / kPi, 1 / kPi).weight;
    EXPECT_NEAR(mergeVertices(strategies_, light, eye, inverseDisk).value.x, 0.8 / kPi * inverseDisk * weight,
                1e-5);
}

TEST(ConnectVertices, AWallBetweenThemBlocks) {
    SceneBuilder b;
    const ShapePtr floor = b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    const ShapePtr ceiling = b.add(test::rectangle({0, 2, 0}, {0, -1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(test::rectangle({0, 1, 0}, {0, 1, 0}, 1, 1), test::diffuse(0.7f));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 8, 8);
    const std::shared_ptr<Scene> scene = b.build();
    const auto at = [](const ShapePtr& shape, const Vec3f& p, const Vec3f& n) {
        Vertex v;
        v.si.shape = shape.get();
        v.si.p = p;
        v.si.ng = v.si.ns = n;
        v.si.s = Frame::fromNormal(n).s;
        v.toPrevious = n;
        v.throughput = Rgb(1.0f);
        v.depth = 1;
        return v;
    };
    const Strategies n = Strategies::bidirectional(1, 0);
    const Vertex below = at(floor, {0, 0, 0}, {0, 1, 0});
    EXPECT_EQ(connectVertices(*scene, n, at(ceiling, {0, 2, 0}, {0, -1, 0}), below).value, Rgb(0.0f));
    EXPECT_EQ(connectVertices(*scene, n, below, below).value, Rgb(0.0f));  // the same point
    // Beside the wall: (rho / pi)^2 cos cos / d^2 with weight one, as no other technique has a density here.
    const Vertex right = at(floor, {3, 0, 0}, {0, 1, 0}), above = at(ceiling, {3, 2, 0}, {0, -1, 0});
    EXPECT_NEAR(connectVertices(*scene, n, above, right).value.x, sqr(0.7f * kInvPi) / 4, 1e-6f);
}

}  // namespace
}  // namespace metrolux::core
