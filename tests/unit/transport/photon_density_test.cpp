#include "transport/photon_density.h"

#include "base/rng.h"
#include "transport/mis.h"

#include <gtest/gtest.h>

namespace metrolux {
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

TEST(PhotonDensity, LimitsWhatMergesCountFor) {
    PhotonDensity d(0.1);
    countUniform(d, 200000, false);
    d.endIteration(200000);
    const Vec3f lit(0.55f, 0.55f, 0.3f), dark(-3, 0, 0);
    const double density = d.at(lit);
    Strategies n = Strategies::bidirectional(2, 10, &d);
    EXPECT_NEAR(n.mergeShare(lit), 1 / (20 * density), 1e-12);  // K = lambda eta * density
    EXPECT_EQ(n.mergeShare(dark), 1);
    n.merge = 0.01;  // fewer than one photon expected
    EXPECT_EQ(n.mergeShare(lit), 1);
    EXPECT_EQ(Strategies::bidirectional(2, 10).mergeShare(lit), 1);
    EXPECT_EQ(Strategies::path().mergeShare(lit), 1);
}

}  // namespace
}  // namespace metrolux
