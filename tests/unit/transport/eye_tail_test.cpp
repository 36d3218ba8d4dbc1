#include "transport/eye_tail.h"

#include "image/hilbert_order.h"
#include "sampling/streams.h"
#include "support/glass_scene.h"
#include "support/small_scenes.h"
#include "transport/eye_pass.h"
#include "transport/light_subpath_pass.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// A floor under a point light: each path is found by nee and by a light subpath that is connected to the
/// camera, so that what eye subpaths estimate is known from both.
std::shared_ptr<Scene> floorUnderLight() {
    test::SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.5f));
    PointLightParameters p;
    p.position = Vec3f(0.5f, 1, 0);
    p.intensity = Rgb(2.0f);
    b.light(makePointLight(p));
    b.camera(Vec3f(0, 3, -3), Vec3f(0, 0, 0), 40, 24, 16);
    b.limits().maxDepth = 2;
    return b.build();
}

/// Light subpaths stand for the second moment of what eye subpaths estimate, whatever the counts and factors.
TEST(EyeTail, LightSubpathsKnowTheSecondMomentOfEyeSubpaths) {
    const std::shared_ptr<Scene> scene = floorUnderLight();
    const PathLimits& limits = scene->parts().limits;
    const ReconstructionFilter box(ReconstructionFilter::Kind::Box, {});
    Film film(scene->camera().window(), box);
    const std::vector<uint32_t> pixels = hilbertOrder(film.width(), film.height());
    NonFiniteCounts nonFinite;
    EyeVertices kept;
    const VertexGrid grid;

    EyeFactors factors(film.window());
    double second = 0;
    for (uint32_t pass = 0; pass < 3; ++pass) {
        const Strategies path = Strategies::path();
        EyePass{*scene, limits, path, nonFinite, 7, pass, &factors}.run(pixels, film, kept);
        factors.endPass();
        film.endPass();
        for (size_t i = 0; i < pixels.size(); ++i) second += sqr(double(factors.lastOf(i))) / 3;
    }
    EXPECT_GT(factors.mean(1), 8);  // one lamp in full view

    EyeTail tail;
    tail.largest.assign(factors.regionCount(), 0.0f);
    tail.worth.assign(factors.regionCount(), 1.0f);
    tail.pixels = double(pixels.size());
    // Factors of up to 64 leave light subpaths a share that EyeTail takes as it is if there are many of them.
    for (const auto& [factored, lambda] : {std::pair{false, 0.25}, {false, 4.0}, {true, 100.0}}) {
        Strategies n = Strategies::bidirectional(lambda, 0);
        n.connect = 0;
        if (factored) n.eyeFactors = &factors;
        LightSubpathPass pass{*scene, limits, n, kept, grid, nonFinite};
        pass.tail = &tail;
        constexpr int kCount = 40000;
        Surprise sum;
        double squares = 0;
        SplatList splats;
        for (int i = 0; i < kCount; ++i) {
            IndependentStream stream(hashKey(i));
            pass.evaluate({&stream, &splats});
            sum += splats.surprise;
            squares += sqr(splats.surprise.alone);
        }
        const double mean = sum.alone / kCount,
                     deviation = std::sqrt((squares / kCount - sqr(mean)) / kCount);
        // One failure in 16,000 by chance; a tenth would be seen.
        EXPECT_LT(4 * deviation, 0.1 * second);
        EXPECT_NEAR(mean, second, 4 * deviation) << lambda << factored;
        EXPECT_GT(sum.together, 0);
        if (!factored) {
            EXPECT_LT(sum.together, sum.alone) << lambda;
        }
    }
}

TEST(EyeTail, IsNoSurpriseWhatEyeSubpathsHaveMet) {
    EyeTail tail;
    tail.largest = {3, 1};
    tail.worth = {1, 1};
    const EyeRival rival{0.5f, 1};
    EXPECT_EQ(tail.surprise(0, 1, rival, 1).alone, 0);         // they estimate 2
    EXPECT_DOUBLE_EQ(tail.surprise(1, 1, rival, 1).alone, 4);  // 2 times 1 / (1 - 0.5)
    EXPECT_TRUE(std::isinf(tail.surprise(0, 1, {0, 1}, 1).alone)) << "they never find it";
}

}  // namespace
}  // namespace metrolux::core
