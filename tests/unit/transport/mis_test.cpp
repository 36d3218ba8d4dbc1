/// Identities of the recursive weights. That they equal brute-force weights along whole paths is
/// tests/oracle's business.

#include "transport/mis.h"

#include "base/rng.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

TEST(Mis, PathTracingKnowsHitAndNeeOnly) {
    // One diffuse vertex before a light: hit and nee with densities p_b (scattering) and p_l (nee), per solid
    // angle.
    const Strategies n = Strategies::path();
    MisState eye = MisState::startEye(n, 3.0);
    EXPECT_EQ(eye.dVCM, 0);  // the camera cannot be connected to
    eye.arrive(4, 0.5);
    const double pb = 0.3, pl = 1.7, cosineSurface = 0.4, cosineLight = 0.8, d2 = 2.5;
    LightEdge e;
    e.connect = pl, e.position = 0.1, e.direction = 0.2;
    e.cosineLight = cosineLight, e.cosineSurface = cosineSurface, e.distanceSquared = d2;
    const double nee = neeWeight(n, eye, e, pb, 0.25);
    EXPECT_NEAR(nee, pl / (pl + pb), 1e-12);

    MisState after = eye;
    after.scatter(n, cosineSurface, pb, 0.25);
    after.arrive(d2, cosineLight);
    const double connectArea = pl * cosineLight / d2;
    EXPECT_NEAR(hitWeight(n, after, connectArea, 0.02), pb / (pl + pb), 1e-12);
}

TEST(Mis, NeeHasAllTheWeightAtDeltaLightsWithoutLightSubpaths) {
    LightEdge e;
    e.delta = true;
    e.kind = EndpointKind::DeltaPosition;
    e.distanceSquared = 9;
    EXPECT_EQ(neeWeight(Strategies::path(), MisState{}, e, 5, 5), 1);
}

TEST(Mis, EmissionOverConnectionOfEachKindOfEndpoint) {
    LightEdge e;
    e.connect = 0.5, e.position = 0.25, e.direction = 0.75, e.cosineLight = 0.3, e.cosineSurface = 0.6,
    e.distanceSquared = 4;
    e.kind = EndpointKind::Surface;  // x0 -> x1: p_A p_w cos1 / d^2 over p_nee cos0 / d^2
    EXPECT_NEAR(e.emissionOverConnection(), 0.25 * 0.75 * 0.6 / (0.5 * 0.3), 1e-12);
    e.kind = EndpointKind::DeltaPosition;
    EXPECT_NEAR(e.emissionOverConnection(), 0.25 * 0.75 * 0.6 / (0.5 * 4), 1e-12);
    e.kind = EndpointKind::Infinite;
    EXPECT_NEAR(e.emissionOverConnection(), 0.25 * 0.75 * 0.6 / 0.5, 1e-12);
}

TEST(Mis, MoreSamplesOfATechniqueGiveItMoreWeight) {
    MisState light{0.3, 0.2, 0.1}, eye{0.4, 0.5, 0.6};
    const double few = mergeWeight(Strategies::bidirectional(1, 0.01), light, eye, 0.3, 0.3);
    const double many = mergeWeight(Strategies::bidirectional(1, 1), light, eye, 0.3, 0.3);
    EXPECT_LT(few, many);
    const double without = connectWeight(Strategies::bidirectional(1, 0), light, eye, 0.2, 0.3, 0.4, 0.5);
    const double with = connectWeight(Strategies::bidirectional(1, 1), light, eye, 0.2, 0.3, 0.4, 0.5);
    EXPECT_LT(with, without);
    Strategies rare = Strategies::bidirectional(1, 1);
    rare.connect = 0.1;
    EXPECT_LT(connectWeight(rare, light, eye, 0.2, 0.3, 0.4, 0.5), with);
    EXPECT_GT(mergeWeight(rare, light, eye, 0.3, 0.3), many);
    // Light subpaths of q-fold density weaken hit.
    EXPECT_LT(hitWeight(Strategies::bidirectional(10, 0), eye, 0, 0.2),
              hitWeight(Strategies::bidirectional(1, 0), eye, 0, 0.2));
}

TEST(Mis, WeightsAreProbabilities) {
    CounterRng rng(1);
    const auto random = [&] { return std::exp(16 * (rng.nextDouble() - 0.5)); };
    for (int i = 0; i < 2000; ++i) {
        const Strategies n = Strategies::bidirectional(random(), random());
        const MisState light{random(), random(), random()}, eye{random(), random(), random()};
        LightEdge e;
        e.kind = static_cast<EndpointKind>(i % 3), e.delta = i % 2 == 0;
        e.connect = random(), e.position = random(), e.direction = random();
        for (const double w :
             {hitWeight(n, eye, random(), random()), neeWeight(n, eye, e, random(), random()),
              splatWeight(n, light, random(), random()), mergeWeight(n, light, eye, random(), random()),
              connectWeight(n, light, eye, random(), random(), random(), random())})
            ASSERT_TRUE(w > 0 && w <= 1) << w;
    }
}

TEST(Mis, DeltaScatteringKeepsOnlyWhatCanStillBeJoined) {
    MisState s{2, 3, 4};
    s.scatterDelta(0.5, 1, 1);
    EXPECT_EQ(s.dVCM, 0);
    EXPECT_DOUBLE_EQ(s.dVC, 1.5);
    EXPECT_DOUBLE_EQ(s.dVM, 2);
    s.arrive(100, 0.5);  // the distance does not matter to sums that have no density of their own
    EXPECT_DOUBLE_EQ(s.dVC, 3);
    EXPECT_EQ(s.dVCM, 0);
}

TEST(Mis, ScatteringThereAndBackThroughARefractionCancels) {
    // Solid angle ratios of entering and leaving are each other's inverses.
    MisState s{0, 7, 11};
    s.scatterDelta(0.9, 1, 1 / 2.25);
    s.scatterDelta(1 / 0.9, 1, 2.25);
    EXPECT_NEAR(s.dVC, 7, 1e-12);
    EXPECT_NEAR(s.dVM, 11, 1e-12);
}

TEST(Mis, ALightThatNextEventCannotReachTakesNoPart) {
    LightEdge e;
    e.delta = true;
    e.kind = EndpointKind::DeltaPosition;
    e.connect = 0;
    const MisState s =
        MisState::arriveFromLight(Strategies::bidirectional(1, 0.1), e, e.emissionOverConnection());
    EXPECT_EQ(s.dVCM, 0);
    EXPECT_EQ(s.dVC, 0);
    EXPECT_EQ(splatWeight(Strategies::bidirectional(1, 0), s, 1, 1), 1);
}

}  // namespace
}  // namespace metrolux::core
