#include "sampling/streams.h"
#include "support/small_scenes.h"
#include "transport/connect.h"
#include "transport/eye_pass.h"
#include "transport/light_pass.h"
#include "transport/subpath.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <set>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

std::shared_ptr<Scene> glassScene() {
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(makeSphere(Transform(), {0, 1, 0}, 0.7f, false), makeDielectric({}));
    b.emit(b.add(test::rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)), Rgb(5));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, 48, 40);
    b.limits().maxDepth = 6;
    return b.build();
}

ReconstructionFilter gaussian() { return {ReconstructionFilter::Kind::Gaussian, {}}; }

struct EyeResult {
    std::vector<float> image;
    EyeVertices eyes;
};
void runEyePass(const Scene& scene, int threads, EyeResult& result) {
    Film film(scene.camera().window(), gaussian());
    const PathLimits limits = scene.parts().limits;
    const Strategies strategies = Strategies::bidirectional(1, 0.1);
    const std::vector<uint32_t> pixels = hilbertOrder(film.width(), film.height());
    tbb::task_arena arena(threads);
    arena.execute([&] { EyePass{scene, limits, strategies, 7, 0}.run(pixels, film, result.eyes); });
    film.endPass();
    result.image = film.image();
}

TEST(EyePass, GivesTheSameBitsOnOneAndTwoThreads) {
    const std::shared_ptr<Scene> scene = glassScene();
    EyeResult one, two;
    runEyePass(*scene, 1, one);
    runEyePass(*scene, 2, two);
    ASSERT_EQ(one.image, two.image);
    ASSERT_EQ(one.eyes.all().size(), two.eyes.all().size());
    for (size_t i = 0; i < one.eyes.all().size(); ++i) {
        const Vertex &a = one.eyes.all()[i], &b = two.eyes.all()[i];
        ASSERT_EQ(a.si.p, b.si.p);
        ASSERT_EQ(a.throughput, b.throughput);
        ASSERT_EQ(a.pixel, b.pixel);
        ASSERT_EQ(a.mis.dVC, b.mis.dVC);
    }
}

/// Side by side or one by one: the same subpaths, and the same sums to the bit.
TEST(EyePass, SubpathsSideBySideEqualThoseAlone) {
    const std::shared_ptr<Scene> scene = glassScene();
    for (const bool photonMapping : {false, true}) {
        PathLimits limits = scene->parts().limits;
        limits.rouletteDepth = 3;
        const Strategies strategies = Strategies::bidirectional(1, 0.1);
        const std::vector<uint32_t> pixels = hilbertOrder(48, 40);
        Film together(scene->camera().window(), gaussian()), alone(scene->camera().window(), gaussian());
        EyePass pass{*scene, limits, strategies, 7, 5};
        pass.photonMapping = photonMapping;
        EyeVertices eyes;
        pass.run(pixels, together, eyes);

        for (size_t i = 0; i < pixels.size(); ++i) {
            const uint64_t key = pass.key(alone.window(), pixels[i]);
            SobolStream stream(key, pass.pass), nee(EyePass::neeKey(key), pass.pass);
            stream.seek(0);
            float weight = 1;
            const Vec2f raster = alone.samplePosition(pixels[i], stream.next2D(), weight);
            std::vector<Vertex> kept;
            alone.addEye(pixels[i], pass.trace(stream, nee, raster, weight, pixels[i], alone, kept));
            ASSERT_EQ(kept.size(), eyes.subpath(i).size());
            for (size_t k = 0; k < kept.size(); ++k) {
                const Vertex &a = kept[k], &b = eyes.subpath(i)[k];
                ASSERT_EQ(a.si.p, b.si.p);
                ASSERT_EQ(a.toPrevious, b.toPrevious);
                ASSERT_EQ(a.throughput, b.throughput);
                ASSERT_EQ(a.depth, b.depth);
                ASSERT_EQ(a.mis.dVCM, b.mis.dVCM);
                ASSERT_EQ(a.mis.dVC, b.mis.dVC);
                ASSERT_EQ(a.mis.dVM, b.mis.dVM);
            }
        }
        together.endPass();
        alone.endPass();
        ASSERT_EQ(together.image(), alone.image());
    }
}

TEST(EyePass, KeepsTheVerticesOfEachSubpathTogether) {
    const std::shared_ptr<Scene> scene = glassScene();
    EyeResult r;
    runEyePass(*scene, 2, r);
    const std::vector<uint32_t> pixels = hilbertOrder(48, 40);
    ASSERT_EQ(r.eyes.subpathCount(), pixels.size());
    size_t sum = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
        int depth = 0;
        for (const Vertex& v : r.eyes.subpath(i)) {
            EXPECT_EQ(v.pixel, pixels[i]);
            EXPECT_GT(v.depth, depth);
            EXPECT_LT(v.depth, 6);  // at the limit nothing can be joined
            EXPECT_TRUE(v.bsdf().hasSmoothLobe());
            EXPECT_NEAR(v.toPrevious.length(), 1, 1e-5f);
            depth = v.depth;
            ++sum;
        }
    }
    EXPECT_EQ(sum, r.eyes.all().size());
    EXPECT_GT(sum, pixels.size() / 3);
    EXPECT_GE(r.eyes.memoryBytes(), sum * sizeof(Vertex));
}

/// What a light pass over the glass scene needs.
struct EyesOfGlassScene {
    explicit EyesOfGlassScene(float radius) {
        runEyePass(*scene, 1, result);
        grid.build(result.eyes.all(), radius);
    }
    LightPass lightPass(const Strategies& strategies) {
        return {*scene, limits, strategies, result.eyes, grid, film};
    }
    std::shared_ptr<Scene> scene = glassScene();
    EyeResult result;
    VertexGrid grid;
    Film film{scene->camera().window(), gaussian()};
    PathLimits limits = scene->parts().limits;
};

TEST(LightPass, IsAFunctionOfItsStream) {
    EyesOfGlassScene eyes(0.1f);
    const Strategies strategies = Strategies::bidirectional(1, 0.1);
    const LightPass pass = eyes.lightPass(strategies);
    SplatList first, second;
    int visible = 0;
    for (int i = 0; i < 300; ++i) {
        IndependentStream a(hashKey(i)), b(hashKey(i));
        b.next2D();
        const LightJob one{&a, &first}, other{&b, &second};
        pass.evaluate({&one, 1}, Coherence::None);
        pass.evaluate({&other, 1}, Coherence::None);  // entered elsewhere, cleared by itself
        ASSERT_EQ(first.pixels.size(), second.pixels.size());
        ASSERT_EQ(first.film.size(), second.film.size());
        ASSERT_EQ(first.size(), second.size());
        visible += !first.empty();
    }
    EXPECT_GT(visible, 30);
}

/// What a light subpath contributes, by its definition: walked alone, merged with every eye vertex in turn.
class ByDefinition final : public SubpathVisitor {
  public:
    ByDefinition(const LightPass& pass, SampleStream& stream) : pass_(pass) {
        uLens_ = LightPass::lensCoordinates(stream);
        stream.seek(0);
        stream.skip(LightPass::kEyeSubpathCoordinate);
        const double u = stream.next1D(), share = pass.strategies.connect;
        const double n = double(pass.eyes.subpathCount());
        if (u < share) partner_ = pass.eyes.subpath(static_cast<size_t>(u / share * n));
        scale_ = static_cast<float>(n / share);
        traceLightSubpath(pass.scene, stream, pass.limits, pass.strategies, *this);
    }
    bool surface(const Vertex& v) override {
        const int limit = pass_.limits.maxDepth;
        if (!v.bsdf().hasSmoothLobe()) return v.depth + 1 < limit;
        Vec2f raster;
        const Rgb toCamera = connectToCamera(pass_.scene, pass_.strategies, v, uLens_, true, raster);
        if (v.depth < limit && !isBlack(toCamera)) splats.film.push_back({raster, toCamera});
        for (const Vertex& eye : partner_)
            if (v.depth + eye.depth + 1 <= limit)
                add(eye.pixel, connectVertices(pass_.scene, pass_.strategies, v, eye) * scale_);
        const float r = pass_.grid.radius();
        for (const Vertex& eye : pass_.eyes.all())
            if ((eye.si.p - v.si.p).length2() <= r * r && v.depth + eye.depth <= limit)
                add(eye.pixel, mergeVertices(pass_.strategies, v, eye, 1.0 / (double(kPi) * r * r)));
        trail.push_back(v.si.p);
        return v.depth + 1 < limit;
    }
    SplatList splats;
    std::vector<Vec3f> trail;

  private:
    void add(uint32_t pixel, const Rgb& value) {
        if (!isBlack(value)) splats.pixels.push_back({pixel, value});
    }
    const LightPass& pass_;
    Vec2f uLens_;
    std::span<const Vertex> partner_;
    float scale_ = 1;
};

TEST(LightPass, SubpathsSideBySideAreThoseByDefinition) {
    EyesOfGlassScene eyes(0.25f);
    PhotonDensity photons(0.4), counted(0.4), expectedCounts(0.4);
    for (const Vertex& v : eyes.result.eyes.all()) photons.count(v.si.p);
    photons.endIteration(1000);
    Strategies strategies = Strategies::bidirectional(1, 0.1, &photons);
    strategies.connect = 0.5;
    const LightPass pass = eyes.lightPass(strategies);

    constexpr size_t kCount = 400;
    std::vector<IndependentStream> streams;
    std::vector<SplatList> splats(kCount), alone(kCount);
    std::vector<std::vector<Vec3f>> trails(kCount);
    std::vector<LightJob> jobs;
    streams.reserve(kCount);
    for (size_t i = 0; i < kCount; ++i) {
        streams.emplace_back(hashKey(i));
        splats[i].film.push_back({});  // to be cleared
        jobs.push_back({&streams[i], &splats[i], &counted, &trails[i]});
    }
    for (const Coherence coherence : {Coherence::Alone, Coherence::None}) {
        pass.evaluate(jobs, coherence);
        size_t pixels = 0, onFilm = 0;
        for (size_t i = 0; i < kCount; ++i) {
            IndependentStream stream(hashKey(i));
            ByDefinition expected(pass, stream);
            ASSERT_EQ(trails[i], expected.trail);
            if (coherence == Coherence::Alone)
                for (const Vec3f& p : expected.trail) expectedCounts.count(p);
            ASSERT_EQ(splats[i].film.size(), expected.splats.film.size()) << i;
            for (size_t k = 0; k < splats[i].film.size(); ++k) {
                ASSERT_EQ(splats[i].film[k].position, expected.splats.film[k].position);
                ASSERT_EQ(splats[i].film[k].value, expected.splats.film[k].value);
            }
            // In which order a vertex merges and connects is the pass's own affair.
            const auto sorted = [](const SplatList& list) {
                std::vector<std::array<float, 4>> result;
                for (const auto& s : list.pixels)
                    result.push_back({static_cast<float>(s.pixel), s.value.x, s.value.y, s.value.z});
                std::sort(result.begin(), result.end());
                return result;
            };
            ASSERT_EQ(sorted(splats[i]), sorted(expected.splats)) << i;
            pixels += splats[i].pixels.size();
            onFilm += splats[i].film.size();
            // One by one: the order too.
            const LightJob one{&streams[i], &alone[i]};
            pass.evaluate({&one, 1}, Coherence::Alone);
            ASSERT_EQ(alone[i].size(), splats[i].size());
        }
        EXPECT_GT(pixels, kCount);
        EXPECT_GT(onFilm, kCount / 3);
        if (coherence == Coherence::Alone) {
            counted.endIteration(kCount);
            expectedCounts.endIteration(kCount);
            for (const Vertex& v : eyes.result.eyes.all())
                ASSERT_EQ(counted.at(v.si.p), expectedCounts.at(v.si.p));
        }
    }
}

TEST(HilbertOrder, VisitsEveryPixelOnce) {
    for (const auto& [w, h] :
         {std::pair(1, 1), std::pair(1, 7), std::pair(16, 16), std::pair(33, 5), std::pair(640, 2)}) {
        const std::vector<uint32_t> order = hilbertOrder(w, h);
        EXPECT_EQ(order.size(), size_t(w) * h);
        EXPECT_EQ(std::set<uint32_t>(order.begin(), order.end()).size(), order.size());
        EXPECT_EQ(*std::max_element(order.begin(), order.end()), uint32_t(w * h - 1));
    }
}

TEST(HilbertOrder, GoesFromNeighborToNeighborInSquares) {
    for (const int size : {2, 4, 8, 64, 128}) {
        const std::vector<uint32_t> order = hilbertOrder(size, size);
        for (size_t i = 1; i < order.size(); ++i) {
            const int ax = order[i] % size, ay = order[i] / size, bx = order[i - 1] % size,
                      by = order[i - 1] / size;
            ASSERT_EQ(std::abs(ax - bx) + std::abs(ay - by), 1) << size << " at " << i;
        }
    }
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
    EXPECT_GT(mergeVertices(strategies_, vertex({0, 1, 0}, {-0.3f, 1, 0}), eye, 1).x, 0);
    EXPECT_EQ(mergeVertices(strategies_, vertex({0, -1, 0}, {-0.3f, -1, 0}), eye, 1), Rgb(0.0f));
    EXPECT_EQ(mergeVertices(strategies_, vertex({1, 0, 0}, {1, 0.3f, 0}), eye, 1), Rgb(0.0f));
    // Curved surfaces go on.
    EXPECT_GT(mergeVertices(strategies_, vertex(normalize(Vec3f(0.3f, 1, 0)), {-0.3f, 1, 0}), eye, 1).x, 0);
}

TEST_F(MergeTest, IsTheReflectanceOverPiPerDisk) {
    const Vertex eye = vertex({0, 1, 0}, {0, 1, 0}), light = vertex({0, 1, 0}, {-1, 1, 0});
    const double inverseDisk = 7;
    const double weight = mergeWeight(strategies_, light.mis, eye.mis, std::cos(kPi / 4) / kPi, 1 / kPi);
    EXPECT_NEAR(mergeVertices(strategies_, light, eye, inverseDisk).x, 0.8 / kPi * inverseDisk * weight,
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
    EXPECT_EQ(connectVertices(*scene, n, at(ceiling, {0, 2, 0}, {0, -1, 0}), below), Rgb(0.0f));
    EXPECT_EQ(connectVertices(*scene, n, below, below), Rgb(0.0f));  // the same point
    // Beside the wall: (rho / pi)^2 cos cos / d^2 with weight one, as no other technique has a density here.
    const Vertex right = at(floor, {3, 0, 0}, {0, 1, 0}), above = at(ceiling, {3, 2, 0}, {0, -1, 0});
    EXPECT_NEAR(connectVertices(*scene, n, above, right).x, sqr(0.7f * kInvPi) / 4, 1e-6f);
}

}  // namespace
}  // namespace metrolux::core
