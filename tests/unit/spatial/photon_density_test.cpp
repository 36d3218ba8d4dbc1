#include "spatial/photon_density.h"

#include "base/rng.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// Uniform photons on a unit square of the plane z = 0.3, tilted or not.
void countUniform(PhotonDensity& d, int n, bool tilted) {
    CounterRng rng(5);
    for (int i = 0; i < n; ++i) {
        const Vec2f u = rng.next2D();
        const float s = std::sqrt(0.5f);
        d.count(tilted ? Vec3f(u.x * s, u.y, u.x * s) : Vec3f(u.x, u.y, 0.3f));
    }
}

TEST(PhotonDensity, MeasuresVerticesPerSubpathAndArea) {
    for (const bool tilted : {false, true}) {
        PhotonDensity d(0.1);
        const Vec3f p = tilted ? Vec3f(0.35f, 0.55f, 0.35f) : Vec3f(0.55f, 0.55f, 0.3f);
        EXPECT_EQ(d.at(p), 0);
        countUniform(d, 200000, tilted);
        EXPECT_EQ(d.at(p), 0) << "counts of an open iteration must not steer it";
        d.endIteration(100000);
        // Two vertices per subpath on the unit square; a cell's cut is known to a few tens of percent only.
        EXPECT_NEAR(d.at(p), 2, 0.7);
        // A mean over iterations, not a sum.
        const double first = d.at(p);
        countUniform(d, 200000, tilted);
        d.endIteration(100000);
        EXPECT_NEAR(d.at(p), first, 1e-9);
        EXPECT_EQ(d.at({7, 7, 7}), 0);
    }
}

TEST(PhotonDensity, CountsSeveralAtOnce) {
    PhotonDensity one(0.1), several(0.1);
    const Vec3f p(0.3f, 0.2f, 0.1f);
    for (int i = 0; i < 5; ++i) one.count(p);
    several.count(p, 5);
    one.endIteration(2);
    several.endIteration(2);
    EXPECT_GT(one.at(p), 0);
    EXPECT_EQ(several.at(p), one.at(p));
}

TEST(PhotonDensity, IsRoughlyWhatItIs) {
    // From one photon of a long rendering to several for each light subpath.
    const Vec3f p(0.3f, 0.2f, 0.1f);
    for (double subpaths = 0.2; subpaths < 0x1p28; subpaths *= 1.37)
        for (const uint32_t photons : {1u, 3u, 100u}) {
            PhotonDensity d(0.1);
            d.count(d.bucketOf(p), photons);
            d.endIteration(subpaths * photons);
            ASSERT_GT(d.at(p), 0);
            ASSERT_NEAR(d.roughlyAt(p) / d.at(p), 1, 1.0 / 16 + 1e-6) << photons << " of " << subpaths;
            ASSERT_EQ(d.roughlyAt({7, 7, 7}), 0);
        }
    // What is rarer counts as nothing, what is more as the most that there is.
    PhotonDensity rare(0.1), dense(0.1);
    rare.count(p);
    rare.endIteration(0x1p29);
    EXPECT_GT(rare.at(p), 0);
    EXPECT_EQ(rare.roughlyAt(p), 0);
    dense.count(p, 1000);
    dense.endIteration(1);
    EXPECT_LT(dense.roughlyAt(p), dense.at(p));
    EXPECT_GT(dense.roughlyAt(p) * 0.1 * 0.1, 8);
}

}  // namespace
}  // namespace metrolux::core
