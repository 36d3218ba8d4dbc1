#include "integrators/iteration.h"
#include "sampling/streams.h"
#include "support/glass_scene.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// A pass of light subpaths in that order is the sum of them one by one, and knows the size of each.
TEST(IndependentLightSubpaths, IsTheSumOfItsSubpaths) {
    const std::shared_ptr<Scene> scene = test::glassScene();
    const Strategies strategies = Strategies::bidirectional(1, 0);
    const EyeVertices eyes;
    const VertexGrid grid;
    const ReconstructionFilter filter(ReconstructionFilter::Kind::Tent, {});
    Film together(scene->camera().window(), filter), alone(scene->camera().window(), filter);
    constexpr size_t kFirst = 11, kCount = 3000;
    std::vector<double> sizes;
    NonFiniteCounts nonFinite;
    const LightSubpathPass pass{*scene, scene->parts().limits, strategies, eyes, grid, nonFinite};
    independentLightSubpaths(pass, together, 3, {7, kFirst, kCount, 0.5}, nullptr, &sizes);
    ASSERT_EQ(sizes.size(), kCount);

    SplatList splats;
    size_t visible = 0;
    for (size_t i = 0; i < kCount; ++i) {
        IndependentStream stream(lightSubpathKey(3, 7, kFirst + i));
        pass.evaluate({&stream, &splats});
        EXPECT_EQ(sizes[i], splats.empty() ? 0 : splats.size()) << i;
        if (splats.empty()) continue;
        ++visible;
        alone.addSplats(splats, 1.0 / kCount, 0.5 / kCount);
    }
    EXPECT_GT(visible, kCount / 20);
    together.endPass();
    alone.endPass();
    EXPECT_EQ(together.image(), alone.image());
}

}  // namespace
}  // namespace metrolux::core
