/// Wavefronts give what the definitions of transport/ give, to the bit.

#include "image/hilbert_order.h"
#include "sampling/streams.h"
#include "support/glass_scene.h"
#include "wavefront/eye_wavefront.h"
#include "wavefront/light_subpath_wavefront.h"
#include "wavefront/prefetching.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

namespace metrolux::core {
namespace {

/// With dispersion: what has it must be known in both forms.
std::shared_ptr<Scene> flintScene(bool fog) {
    return test::glassScene(fog, {RelativeIndex(*Dispersion::named("SF11"), 1)});
}
const Wavelength kWavelength = Wavelength::at(0.3);

struct EyeResult {
    std::vector<float> image;
    EyeVertices eyes;
};

/// Runs a pass over the glass scene with `run(pass, pixels, film, eyes)`.
template <class Run>
EyeResult eyeResult(const Scene& scene, const Strategies& strategies, Run&& run) {
    Film film = test::gaussianFilm(scene);
    PathLimits limits = scene.parts().limits;
    limits.rouletteDepth = 3;
    EyeResult result;
    NonFiniteCounts nonFinite;
    run(EyePass{scene, limits, strategies, nonFinite, 7, 5}, hilbertOrder(film.width(), film.height()), film,
        result.eyes);
    film.endPass();
    result.image = film.image();
    return result;
}
EyeResult inWavefronts(const Scene& scene, const Strategies& strategies, int threads) {
    return eyeResult(scene, strategies,
                     [&](const EyePass& pass, auto&& pixels, Film& film, EyeVertices& eyes) {
                         EyeWavefronts wavefronts;
                         tbb::task_arena arena(threads);
                         arena.execute([&] {
                             wavefronts.run(pass, pixels, film, eyes);
                             EXPECT_GT(wavefronts.memoryBytes(), 0u);
                         });
                     });
}

void expectSameBits(const EyeResult& a, const EyeResult& b) {
    ASSERT_EQ(a.image, b.image);
    ASSERT_EQ(a.eyes.starts, b.eyes.starts);
    ASSERT_EQ(a.eyes.all().size(), b.eyes.all().size());
    for (size_t i = 0; i < a.eyes.all().size(); ++i) {
        const Vertex &v = a.eyes.all()[i], &w = b.eyes.all()[i];
        ASSERT_EQ(v.si.p, w.si.p);
        ASSERT_EQ(v.toPrevious, w.toPrevious);
        ASSERT_EQ(v.throughput, w.throughput);
        ASSERT_EQ(v.depth, w.depth);
        ASSERT_EQ(v.dispersed, w.dispersed);
        ASSERT_EQ(v.si.wavelength, kWavelength.nanometers);
        ASSERT_EQ(w.si.wavelength, kWavelength.nanometers);
        ASSERT_EQ(v.pixel, w.pixel);
        ASSERT_EQ(v.mis.dVCM, w.mis.dVCM);
        ASSERT_EQ(v.mis.dEnd, w.mis.dEnd);
        ASSERT_EQ(v.mis.dInner, w.mis.dInner);
        ASSERT_EQ(v.mis.region, w.mis.region);
        ASSERT_EQ(v.mis.smooth, w.mis.smooth);
        ASSERT_EQ(v.mis.mergeShare, w.mis.mergeShare);
    }
}

/// In the scene without and with fog.
class EyeWavefrontsIn : public ::testing::TestWithParam<bool> {};
class LightSubpathWavefrontIn : public ::testing::TestWithParam<bool> {};

TEST_P(EyeWavefrontsIn, GiveTheBitsOfTheDefinitionOnOneAndTwoThreads) {
    const std::shared_ptr<Scene> scene = flintScene(GetParam());
    for (Strategies strategies : {Strategies::bidirectional(1, 0.1), Strategies::photonMapping()}) {
        strategies.wavelength = kWavelength;
        const EyeResult alone = eyeResult(
            *scene, strategies, [](const EyePass& pass, auto&& pixels, Film& film, EyeVertices& eyes) {
                pass.run(pixels, film, eyes);
            });
        ASSERT_GT(alone.eyes.all().size(), 500u);
        for (const int threads : {1, 2}) expectSameBits(inWavefronts(*scene, strategies, threads), alone);
    }
}

TEST_P(LightSubpathWavefrontIn, GivesTheBitsOfTheDefinition) {
    const std::shared_ptr<Scene> scene = flintScene(GetParam());
    const PathLimits limits = scene->parts().limits;
    Film film = test::gaussianFilm(*scene);
    EyeVertices eyes;
    Strategies forEyes = Strategies::bidirectional(1, 0.1);
    forEyes.wavelength = kWavelength;
    NonFiniteCounts nonFinite;
    EyePass{*scene, limits, forEyes, nonFinite, 7, 0}.run(hilbertOrder(film.width(), film.height()), film,
                                                          eyes);
    VertexGrid grid;
    grid.build(positionsOf(eyes.all()), 0.25f);
    PhotonDensity photons(0.4), counted(0.4), expectedCounts(0.4);
    for (const Vertex& v : eyes.all()) photons.count(v.si.p);
    photons.endIteration(1000);
    Strategies strategies = Strategies::bidirectional(1, 0.1, &photons);
    strategies.connect = 0.5;
    strategies.wavelength = kWavelength;
    strategies.mergeInMedia = GetParam() ? 0.6 : 0;
    LightSubpathPass pass{*scene, limits, strategies, eyes, grid, nonFinite};
    VertexGrid mediumGrid;
    std::vector<uint32_t> inMedia;
    for (uint32_t i = 0; i < eyes.all().size(); ++i)
        if (eyes.vertices[i].inMedium) inMedia.push_back(i);
    mediumGrid.build(positionsOf(eyes.all()), inMedia, 0.4f);
    const std::vector<float> shares(eyes.all().size(), 0.9f);
    pass.mediumGrid = &mediumGrid;
    pass.shareInside = shares;
    ASSERT_EQ(inMedia.size() > 100, GetParam());

    constexpr size_t kCount = 400;
    std::vector<IndependentStream> streams;
    std::vector<SplatList> splats(kCount);
    std::vector<std::vector<Vec3f>> trails(kCount);
    std::vector<LightSubpathJob> jobs;
    streams.reserve(kCount);
    for (size_t i = 0; i < kCount; ++i) {
        streams.emplace_back(hashKey(i));
        splats[i].film.push_back({});  // to be cleared
        jobs.push_back({&streams[i], &splats[i], &counted, &trails[i]});
    }
    for (const Coherence coherence : {Coherence::Alone, Coherence::None}) {
        evaluateTogether(pass, jobs, coherence);
        size_t pixels = 0, onFilm = 0;
        for (size_t i = 0; i < kCount; ++i) {
            IndependentStream stream(hashKey(i));
            SplatList expected;
            std::vector<Vec3f> trail;
            pass.evaluate({&stream, &expected, &expectedCounts, &trail});
            ASSERT_EQ(trails[i], trail);
            ASSERT_EQ(splats[i].film.size(), expected.film.size()) << i;
            for (size_t k = 0; k < splats[i].film.size(); ++k) {
                ASSERT_EQ(splats[i].film[k].position, expected.film[k].position);
                ASSERT_EQ(splats[i].film[k].value, expected.film[k].value);
            }
            ASSERT_EQ(splats[i].pixels.size(), expected.pixels.size()) << i;
            for (size_t k = 0; k < splats[i].pixels.size(); ++k) {
                ASSERT_EQ(splats[i].pixels[k].pixel, expected.pixels[k].pixel);
                ASSERT_EQ(splats[i].pixels[k].value, expected.pixels[k].value);
            }
            pixels += splats[i].pixels.size();
            onFilm += splats[i].film.size();
        }
        EXPECT_GT(pixels, kCount);
        EXPECT_GT(onFilm, kCount / 3);
    }
    counted.endIteration(kCount);
    expectedCounts.endIteration(kCount);
    for (const Vertex& v : eyes.all()) ASSERT_EQ(counted.at(v.si.p), expectedCounts.at(v.si.p));
}

INSTANTIATE_TEST_SUITE_P(Fog, EyeWavefrontsIn, ::testing::Bool());
INSTANTIATE_TEST_SUITE_P(Fog, LightSubpathWavefrontIn, ::testing::Bool());

TEST(StagedGridQuery, FindsWhatAQueryFindsInItsOrder) {
    CounterRng rng(3);
    const auto point = [&] { return Vec3f(rng.next1D(), rng.next1D(), rng.next1D()); };
    std::vector<Vec3f> points(2000);
    for (Vec3f& p : points) p = point();
    VertexGrid grid;
    grid.build(points, 0.1f);
    size_t found = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec3f p = point();
        UninitializedVector<uint32_t> near(1);
        near[0] = 7;  // it appends
        const VertexGrid::Cells cells = grid.cellsOf(p);
        prefetchBuckets(grid, cells);
        prefetchEntries(grid, cells);
        appendWithin(grid, p, cells, near);
        std::vector<uint32_t> expected{7};
        grid.query(p, [&](uint32_t index) { expected.push_back(index); });
        ASSERT_EQ(std::vector<uint32_t>(near.begin(), near.end()), expected);
        found += expected.size() - 1;
    }
    EXPECT_GT(found, 1000u);
}

}  // namespace
}  // namespace metrolux::core
