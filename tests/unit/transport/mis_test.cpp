/// Identities of the recursive weights. That they equal brute-force weights along whole paths is
/// tests/oracle's business.

#include "transport/mis.h"

#include "base/rng.h"
#include "support/eye_factors.h"
#include "transport/vertex.h"

#include <gtest/gtest.h>

#include <array>

namespace metrolux::core {
namespace {

using test::setRandomEyeFactors;

TEST(Mis, PathTracingKnowsHitAndNeeOnly) {
    // One diffuse vertex before a light: hit and nee with densities p_b (scattering) and p_l (nee), per solid
    // angle.
    const Strategies n = Strategies::path();
    MisState eye = MisState::startEye(n, 3.0);
    EXPECT_EQ(eye.dVCM, 0);  // the camera cannot be connected to
    eye.arrive(4, 0.5);
    const double pb = 0.3, pl = 1.7, cosineSurface = 0.4, cosineLight = 0.8, d2 = 2.5;
    LightEdge e;
    e.pdfNee = pl, e.pdfPosition = 0.1, e.pdfDirection = 0.2;
    e.cosineLight = cosineLight, e.cosineSurface = cosineSurface, e.distanceSquared = d2;
    const EyeWeight nee = neeWeight(n, eye, e, pb, 0.25);
    EXPECT_NEAR(nee.weight, pl / (pl + pb), 1e-12);
    EXPECT_EQ(nee.alone, nee.weight);

    MisState after = eye;
    after.scatter(n, cosineSurface, pb, 0.25);
    after.arrive(d2, cosineLight);
    EXPECT_NEAR(hitWeight(n, after, e.pdfNeeAtLight(), 0.02).weight, pb / (pl + pb), 1e-12);
}

TEST(Mis, NeeHasAllTheWeightAtDeltaLightsWithoutLightSubpaths) {
    LightEdge e;
    e.delta = true;
    e.kind = EndpointKind::DeltaPosition;
    e.distanceSquared = 9;
    EXPECT_EQ(neeWeight(Strategies::path(), MisState{}, e, 5, 5).weight, 1);
}

TEST(Mis, EmissionOverNeeOfEachKindOfEndpoint) {
    LightEdge e;
    e.pdfNee = 0.5, e.pdfPosition = 0.25, e.pdfDirection = 0.75, e.cosineLight = 0.3, e.cosineSurface = 0.6,
    e.distanceSquared = 4;
    e.kind = EndpointKind::Surface;  // x0 -> x1: p_A p_w cos1 / d^2 over p_nee cos0 / d^2
    EXPECT_NEAR(e.emissionOverNee(), 0.25 * 0.75 * 0.6 / (0.5 * 0.3), 1e-12);
    e.kind = EndpointKind::DeltaPosition;
    EXPECT_NEAR(e.emissionOverNee(), 0.25 * 0.75 * 0.6 / (0.5 * 4), 1e-12);
    e.kind = EndpointKind::Infinite;
    EXPECT_NEAR(e.emissionOverNee(), 0.25 * 0.75 * 0.6 / 0.5, 1e-12);
}

TEST(Mis, MoreSamplesOfATechniqueGiveItMoreWeight) {
    MisState light{0.3, 0.05, 0.15}, eye{0.4, 0.1, 0.4};
    light.first = eye.first = false;
    const double few = mergeWeight(Strategies::bidirectional(1, 0.01), light, eye, 0.3, 0.3).weight;
    const double many = mergeWeight(Strategies::bidirectional(1, 1), light, eye, 0.3, 0.3).weight;
    EXPECT_LT(few, many);
    const double without =
        connectWeight(Strategies::bidirectional(1, 0), light, eye, 0.2, 0.3, 0.4, 0.5).weight;
    const double with = connectWeight(Strategies::bidirectional(1, 1), light, eye, 0.2, 0.3, 0.4, 0.5).weight;
    EXPECT_LT(with, without);
    Strategies rare = Strategies::bidirectional(1, 1);
    rare.connect = 0.1;
    EXPECT_LT(connectWeight(rare, light, eye, 0.2, 0.3, 0.4, 0.5).weight, with);
    EXPECT_GT(mergeWeight(rare, light, eye, 0.3, 0.3).weight, many);
    // Light subpaths of q-fold density weaken hit.
    EXPECT_LT(hitWeight(Strategies::bidirectional(10, 0), eye, 0, 0.2).weight,
              hitWeight(Strategies::bidirectional(1, 0), eye, 0, 0.2).weight);
}

/// A path of numbers: x_0 on an area light, x_1 ... x_kInner, the camera; edge i joins x_i and x_{i+1}.
struct RandomPath {
    static constexpr int kInner = 4;
    LightEdge first;
    double pdfCamera;                                    ///< of the direction toward x_kInner, from the eye
    std::array<double, kInner + 1> d2, cosNear, cosFar;  ///< of edge i; |cos| at x_i and at x_{i+1}
    std::array<double, kInner + 1> fromLight, fromEye;  ///< at x_i: densities of the directions away and back
    std::array<float, kInner + 1> share;                ///< of merging at x_i
    Vec2f raster;

    explicit RandomPath(CounterRng& rng) {
        const auto random = [&] { return std::exp(3 * (rng.nextDouble() - 0.5)); };
        for (int i = 0; i <= kInner; ++i) {
            d2[i] = random(), cosNear[i] = rng.nextDouble(), cosFar[i] = rng.nextDouble();
            fromLight[i] = random(), fromEye[i] = random();
            share[i] = i == kInner ? 1.0f : 1 - rng.next1D();  // the first eye vertex is not there by chance
        }
        pdfCamera = random();
        raster = {32 * rng.next1D(), 16 * rng.next1D()};
        first.pdfNee = random(), first.pdfPosition = random(), first.pdfDirection = random();
        first.cosineLight = cosNear[0], first.cosineSurface = cosFar[0], first.distanceSquared = d2[0];
    }

    double sumOfWeights(const Strategies& n) const {
        std::array<MisState, kInner + 1> light, eye;  // at x_i
        light[1] = MisState::arriveFromLight(n, first);
        light[1].mergeShare = share[1];
        for (int i = 1; i < kInner; ++i) {
            light[i + 1] = light[i];
            light[i + 1].scatter(n, cosNear[i], fromLight[i], fromEye[i]);
            light[i + 1].arrive(d2[i], cosFar[i]);
            light[i + 1].mergeShare = share[i + 1];
        }
        eye[kInner] = MisState::startEye(n, pdfCamera, n.regionOf(raster));
        eye[kInner].arrive(d2[kInner], cosNear[kInner]);
        for (int i = kInner; i > 0; --i) {
            eye[i - 1] = eye[i];
            eye[i - 1].scatter(n, cosFar[i - 1], fromEye[i], fromLight[i]);
            eye[i - 1].arrive(d2[i - 1], cosNear[i - 1]);
            eye[i - 1].mergeShare = share[i - 1];
        }
        double sum = 0, ofEye = 0;
        std::vector<LightWeight> ofLight;
        if (n.hit > 0) ofEye += hitWeight(n, eye[0], first.pdfNeeAtLight(), first.pdfEmission()).weight;
        if (n.nee > 0) ofEye += neeWeight(n, eye[1], first, fromEye[1], fromLight[1]).weight;
        for (int i = 1; i < kInner && n.connect > 0; ++i)
            ofLight.push_back(connectWeight(n, light[i], eye[i + 1], fromEye[i + 1] * cosNear[i] / d2[i],
                                            fromLight[i] * cosFar[i] / d2[i], fromEye[i], fromLight[i + 1]));
        if (n.splat > 0)
            ofLight.push_back(splatWeight(n, light[kInner], n.regionOf(raster),
                                          pdfCamera * cosNear[kInner] / d2[kInner], fromEye[kInner]));
        for (int i = 1; i <= kInner && n.merge > 0; ++i)
            ofLight.push_back(mergeWeight(n, light[i], eye[i], fromEye[i], fromLight[i]));
        sum += ofEye;
        for (const LightWeight& w : ofLight) {
            sum += w.weight;
            EXPECT_NEAR(w.eye.share, ofEye, 1e-6);  // each technique knows what hit and nee have of the path
        }
        return sum;
    }
};

TEST(Mis, WeightsOfAPathSumToOneForEverySetOfTechniques) {
    CounterRng rng(1);
    EyeFactors factors({32, 16, 0, 0, 32, 16});
    setRandomEyeFactors(factors, 32 * 16, rng);
    for (int set = 1; set < 32; ++set)
        for (int i = 0; i < 20; ++i) {
            const auto count = [&](int technique) {
                return set >> technique & 1 ? 0.1 + rng.nextDouble() : 0.0;
            };
            const Strategies n{.hit = count(0),
                               .nee = count(1),
                               .connect = count(2),
                               .splat = count(3),
                               .merge = count(4),
                               .eyeFactors = i % 2 ? &factors : nullptr};
            ASSERT_NEAR(RandomPath(rng).sumOfWeights(n), 1, 1e-9) << "set " << set;
        }
}

TEST(Mis, DeltaScatteringKeepsOnlyWhatCanStillBeJoined) {
    MisState s{2, 3, 4};
    s.scatterDelta(0.5, 1, 1);
    EXPECT_EQ(s.dVCM, 0);
    EXPECT_DOUBLE_EQ(s.dEnd, 1.5);
    EXPECT_DOUBLE_EQ(s.dInner, 2);
    EXPECT_EQ(s.smooth, 0);
    s.arrive(100, 0.5);  // the distance does not matter to sums that have no density of their own
    EXPECT_DOUBLE_EQ(s.dEnd, 3);
    EXPECT_EQ(s.dVCM, 0);
}

TEST(Mis, ScatteringThereAndBackThroughARefractionCancels) {
    // Solid angle ratios of entering and leaving are each other's inverses.
    MisState s{0, 7, 11};
    s.scatterDelta(0.9, 1, 1 / 2.25);
    s.scatterDelta(1 / 0.9, 1, 2.25);
    EXPECT_NEAR(s.dEnd, 7, 1e-12);
    EXPECT_NEAR(s.dInner, 11, 1e-12);
}

TEST(Mis, ALightThatNextEventCannotReachTakesNoPart) {
    LightEdge e;
    e.delta = true;
    e.kind = EndpointKind::DeltaPosition;
    e.pdfNee = 0;
    const MisState s = MisState::arriveFromLight(Strategies::bidirectional(1, 0.1), e);
    EXPECT_EQ(s.dVCM, 0);
    EXPECT_EQ(s.dEnd + s.dInner, 0);
    EXPECT_EQ(splatWeight(Strategies::bidirectional(1, 0), s, 0, 1, 1).weight, 1);
}

TEST(Strategies, PhotonDensityLimitsWhatMergesCountFor) {
    PhotonDensity d(0.1);
    CounterRng rng(5);
    for (int i = 0; i < 200000; ++i) {  // uniform on a unit square
        const Vec2f u = rng.next2D();
        d.count({u.x, u.y, 0.3f});
    }
    d.endIteration(200000);
    const Vec3f lit(0.55f, 0.55f, 0.3f), dark(-3, 0, 0);
    const double density = d.roughlyAt(lit);
    EXPECT_NEAR(density / d.at(lit), 1, 1.0 / 16);
    Strategies n = Strategies::bidirectional(2, 10, &d);
    EXPECT_NEAR(n.mergeShare(lit), 1 / (20 * density), 1e-12);  // K = lambda eta * density
    EXPECT_EQ(n.mergeShare(dark), 1);
    n.merge = 0.01;  // fewer than one photon expected
    EXPECT_EQ(n.mergeShare(lit), 1);
    EXPECT_EQ(Strategies::bidirectional(2, 10).mergeShare(lit), 1);
    EXPECT_EQ(Strategies::path().mergeShare(lit), 1);
}

TEST(Vertex, IsSmallAndPlain) {
    // Not formally trivially copyable only because Imath's vectors declare their copies.
    static_assert(std::is_trivially_destructible_v<Vertex> && std::is_nothrow_copy_constructible_v<Vertex>);
    RecordProperty("bytes", static_cast<int>(sizeof(Vertex)));
    EXPECT_LE(sizeof(Vertex), 160u);
}

}  // namespace
}  // namespace metrolux::core
