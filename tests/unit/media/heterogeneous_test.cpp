#include "base/error.h"
#include "media/medium.h"
#include "unit/media/grid_cases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

std::string messageOf(const std::function<void()>& make) {
    try {
        make();
    } catch (const Error& error) {
        return error.what();
    }
    return "none";
}

TEST(Heterogeneous, ConstantDensityEndsAtItsBox) {
    const MediumPtr medium = makeHeterogeneousMedium(
        makeConstantVolume(Rgb(0.5f, 0.4f, 0.3f), Transform::translate({-0.5, -0.5, -0.5})), 5,
        makeConstantVolume(Rgb(0.0f)), makeIsotropicPhase());
    const Rgb through = medium->thickness({0, 0, -3}, {0, 0, 1}, kInfinity);
    EXPECT_FLOAT_EQ(through.x, 2.5f);
    EXPECT_FLOAT_EQ(through.y, 2.0f);
    EXPECT_FLOAT_EQ(through.z, 1.5f);
    EXPECT_FLOAT_EQ(medium->thickness({0, 0, 0.25f}, {0, 0, 1}, kInfinity).x, 0.625f);
    EXPECT_FLOAT_EQ(medium->thickness({0, 0, 0.25f}, {0, 0, -1}, 0.5f).x, 1.25f);
    EXPECT_EQ(medium->thickness({0.6f, 0, -3}, {0, 0, 1}, kInfinity), Rgb(0.0f)) << "beside the box";
    EXPECT_EQ(medium->thickness({0, 0, -3}, {0, 0, -1}, kInfinity), Rgb(0.0f)) << "behind the ray";
    EXPECT_EQ(medium->thickness({0, 0, -3}, {0, 0, 1}, 2), Rgb(0.0f)) << "beyond the segment";
    const auto flight = medium->fly({0, 0, -3}, {0, 0, 1}, kInfinity, 1, 1);
    ASSERT_TRUE(flight);
    EXPECT_FLOAT_EQ(flight->distance, 3);
    EXPECT_FLOAT_EQ(flight->thickness.x, 1.25f);
    EXPECT_FALSE(medium->fly({0, 0, -3}, {0, 0, 1}, kInfinity, 1, 2.001f));
    EXPECT_FALSE(medium->scatters());
}

TEST(Heterogeneous, UnboundedConstantsAreHomogeneous) {
    const MediumPtr medium = makeHeterogeneousMedium(makeConstantVolume(Rgb(0.5f, 0, 2)), 3,
                                                     makeConstantVolume(Rgb(0.25f)), makeIsotropicPhase());
    const Rgb infinite = medium->thickness({100, 0, 0}, {0, 0, 1}, kInfinity);
    EXPECT_EQ(infinite.x, kInfinity);
    EXPECT_EQ(infinite.y, 0) << "a channel that passes";
    EXPECT_FLOAT_EQ(medium->fly({100, 0, 0}, {0, 0, 1}, kInfinity, 2, 3)->distance, 0.5f);
    EXPECT_FALSE(medium->fly({100, 0, 0}, {0, 0, 1}, kInfinity, 1, 0));
}

TEST(Heterogeneous, UnboundedDensityWithAnAlbedoFromAGrid) {
    const VolumePtr albedo = makeGridVolume(test::randomSamples({4, 4, 4}, 3, 2), {});
    const MediumPtr medium =
        makeHeterogeneousMedium(makeConstantVolume(Rgb(0.5f, 0, 2)), 3, albedo, makeIsotropicPhase());
    EXPECT_EQ(medium->thickness({100, 0, 0}, {0, 0, 1}, kInfinity).x, kInfinity);
    EXPECT_EQ(medium->thickness({100, 0, 0}, {0, 0, 1}, kInfinity).y, 0);
    EXPECT_FLOAT_EQ(medium->thickness({100, 0, 0}, {0, 0, 1}, 2).z, 12);
    EXPECT_FLOAT_EQ(medium->fly({100, 0, 0}, {0, 0, 1}, kInfinity, 2, 3)->distance, 0.5f);
    const Vec3f p(0.3f, 0.6f, 0.7f);
    EXPECT_EQ(medium->scattering(p), medium->extinction(p) * albedo->value(p));
    EXPECT_TRUE(medium->scatters());
}

TEST(Heterogeneous, CoefficientsAreScaledValues) {
    const VolumePtr density = makeGridVolume(test::randomSamples({5, 4, 3}, 3, 3), {}),
                    albedo = makeGridVolume(test::randomSamples({3, 3, 3}, 1, 4),
                                            {.toWorld = Transform::rotate({1, 0, 0}, 30)});
    const MediumPtr medium = makeHeterogeneousMedium(density, 7, albedo, makeIsotropicPhase());
    const Vec3f p(0.4f, 0.3f, 0.8f);
    for (int c = 0; c < 3; ++c) {
        EXPECT_FLOAT_EQ(medium->extinction(p)[c], 7 * density->value(p)[c]);
        EXPECT_FLOAT_EQ(medium->scattering(p)[c], 7 * density->value(p)[c] * albedo->value(p)[c]);
    }
    // The derivative of the thickness.
    const Vec3f direction = normalize(Vec3f(1, -2, 0.5f));
    constexpr float kStep = 1e-3f;
    const Rgb around = medium->thickness(p - direction * kStep, direction, 2 * kStep);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(around[c] / (2 * kStep), medium->extinction(p)[c], 1e-3f);
}

TEST(Heterogeneous, RefusesBadNumbers) {
    const VolumePtr one = makeConstantVolume(Rgb(1.0f)), two = makeConstantVolume(Rgb(1, 1, 2));
    const auto make = [&](const VolumePtr& density, float scale, const VolumePtr& albedo) {
        return messageOf([&] { makeHeterogeneousMedium(density, scale, albedo, makeIsotropicPhase()); });
    };
    const VolumePtr grid = makeGridVolume(test::randomSamples({2, 2, 2}, 1, 3), {});
    EXPECT_EQ(make(grid, 1, one), "none");
    EXPECT_THAT(make(grid, -1, one), testing::HasSubstr("scale is -1"));
    EXPECT_THAT(make(grid, kInfinity, one), testing::HasSubstr("scale is inf"));
    EXPECT_THAT(make(grid, 1, two), testing::HasSubstr("albedo is 2 in channel 2"));
    GridSamples large = test::randomSamples({2, 2, 2}, 1, 3);
    large.values[3] = 1e30f;
    EXPECT_THAT(make(makeGridVolume(large, {}), 1e10f, one), testing::HasSubstr("expected a finite product"));
    EXPECT_THAT(messageOf([] { makeConstantVolume(Rgb(1, -2, 1)); }), testing::HasSubstr("-2 in channel 1"));
    EXPECT_THAT(messageOf([] {
                    makeConstantVolume(Rgb(1.0f), Transform::scale({1, 1, 0}));
                }),
                testing::HasSubstr("flattens"));
}

}  // namespace
}  // namespace metrolux::core
