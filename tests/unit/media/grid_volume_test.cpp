#include "base/error.h"
#include "media/medium.h"
#include "unit/media/grid_cases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

using test::GridCase;
using test::gridCases;
using test::Segment;
using test::segmentsFor;

MediumPtr mediumOf(const VolumePtr& density, float scale = 1) {
    return makeHeterogeneousMedium(density, scale, makeConstantVolume(Rgb(0.5f)), makeIsotropicPhase());
}

TEST(GridVolume, ValuesAreThoseOfTheDefinition) {
    for (const GridCase& grid : gridCases()) {
        const VolumePtr volume = grid.volume();
        CounterRng rng(3);
        for (int i = 0; i < 50; ++i) {
            const Vec3d local(rng.nextDouble() * 4 - 1.5, rng.nextDouble() * 4 - 1.5,
                              rng.nextDouble() * 4 - 1.5);
            const Vec3f p(grid.settings.toWorld.exactPoint(local));
            if (grid.settings.placement == GridPlacement::Nodes) {
                const Vec3d q = grid.settings.toWorld.inverse().exactPoint(Vec3d(p));
                bool isAtFace = false;  // where the tolerance of points on faces is felt
                for (int a = 0; a < 3; ++a)
                    isAtFace = isAtFace || std::abs(q[a]) < 1e-3 || std::abs(q[a] - 1) < 1e-3;
                if (isAtFace) continue;
            }
            const Rgb value = volume->value(p);
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(double(value[c]), grid.value(Vec3d(p), c), 1e-6) << grid.name;
        }
    }
}

TEST(GridVolume, BoundsHoldTheUnitCube) {
    for (const auto& [name, transform] : test::gridTransforms()) {
        const GridCase grid{name, test::randomSamples({2, 2, 2}, 1, 1), {.toWorld = transform}};
        const Imath::Box3d box = grid.volume()->bounds();
        for (int a = 0; a < 3; ++a) {
            // Just inside and outside of each face.
            for (const double side : {box.min[a], box.max[a]}) {
                Vec3d p = box.center();
                p[a] = side + 1e-9;
                EXPECT_EQ(grid.isWithinBounds(p), side == box.min[a]) << name;
                p[a] = side - 1e-9;
                EXPECT_EQ(grid.isWithinBounds(p), side == box.max[a]) << name;
            }
        }
    }
}

TEST(GridVolume, ThicknessIsTheIntegralOfTheDefinition) {
    double largest = 0;
    for (const GridCase& grid : gridCases()) {
        const MediumPtr medium = mediumOf(grid.volume(), 2);
        uint64_t seed = 0;
        for (const Segment& s : segmentsFor(grid, ++seed)) {
            const Rgb thickness = medium->thickness(s.origin, s.direction, s.length);
            for (int c = 0; c < grid.samples.channels; ++c) {
                const double expected =
                    2 * grid.integral(Vec3d(s.origin), Vec3d(s.direction), double(s.length), c);
                // The midpoint rule has an error of 1e-5 or so of a cell's integral.
                ASSERT_NEAR(double(thickness[c]), expected, 3e-4 * expected + 1e-6)
                    << grid.name << ", channel " << c << ", from " << s.origin << " along " << s.direction
                    << ", length " << s.length;
                largest = std::max(largest, expected);
            }
            if (grid.samples.channels == 1) {
                EXPECT_EQ(thickness.x, thickness.y);
                EXPECT_EQ(thickness.x, thickness.z);
            }
        }
    }
    EXPECT_GT(largest, 1);
}

TEST(GridVolume, InfiniteSegmentsEndAtTheBounds) {
    for (const GridCase& grid : gridCases()) {
        const MediumPtr medium = mediumOf(grid.volume());
        for (const Segment& s : segmentsFor(grid, 7)) {
            const Rgb infinite = medium->thickness(s.origin, s.direction, kInfinity),
                      finite = medium->thickness(s.origin, s.direction, 100);
            for (int c = 0; c < 3; ++c) {
                ASSERT_TRUE(std::isfinite(infinite[c]));
                ASSERT_EQ(infinite[c], finite[c]) << grid.name;
            }
        }
    }
}

TEST(GridVolume, ThicknessIsThatOfTheWayBackAndOfTheParts) {
    for (const GridCase& grid : gridCases()) {
        const MediumPtr medium = mediumOf(grid.volume());
        CounterRng rng(4);
        for (const Segment& s : segmentsFor(grid, 8)) {
            const Rgb there = medium->thickness(s.origin, s.direction, s.length);
            const Vec3f end = s.origin + s.direction * s.length;
            const Rgb back = medium->thickness(end, -s.direction, s.length);
            const float middle = s.length * rng.next1D();
            const Rgb first = medium->thickness(s.origin, s.direction, middle),
                      second =
                          medium->thickness(s.origin + s.direction * middle, s.direction, s.length - middle);
            for (int c = 0; c < 3; ++c) {
                // Single precision moves the points by some 1e-6.
                const float bound = 2e-5f * there[c] + 2e-5f;
                // A ray that stays on a face takes the values of one side.
                const bool isOnFace = grid.settings.filter == GridFilter::Nearest ||
                                      grid.settings.placement == GridPlacement::Nodes;
                if (!isOnFace) {
                    ASSERT_NEAR(there[c], back[c], bound) << grid.name;
                }
                ASSERT_NEAR(there[c], first[c] + second[c], isOnFace ? 2e-2f : bound) << grid.name;
            }
        }
    }
}

TEST(GridVolume, FlightsReachTheirThickness) {
    int reached = 0;
    for (const GridCase& grid : gridCases()) {
        const MediumPtr medium = mediumOf(grid.volume(), 3);
        CounterRng rng(5);
        for (const Segment& s : segmentsFor(grid, 9))
            for (int i = 0; i < 4; ++i) {
                const int channel = i % 3;
                const float whole = medium->thickness(s.origin, s.direction, s.length)[channel];
                const float target = rng.next1D() * (whole > 0 ? 1.2f * whole : 1.0f);
                const auto flight = medium->fly(s.origin, s.direction, s.length, channel, target);
                if (std::abs(target - whole) > 1e-5f * whole) {
                    ASSERT_EQ(flight.has_value(), target < whole) << grid.name;
                }
                if (!flight) continue;
                ++reached;
                ASSERT_GE(flight->distance, 0);
                ASSERT_LE(flight->distance, s.length);
                ASSERT_NEAR(flight->thickness[channel], target, 1e-5f * target + 1e-7f);
                // The distance is in single precision: what a step of it means is allowed for.
                const float step = 2 * std::numeric_limits<float>::epsilon() * flight->distance * 3;
                const Rgb thickness = medium->thickness(s.origin, s.direction, flight->distance);
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(flight->thickness[c], thickness[c], 1e-5f * thickness[c] + step) << grid.name;
            }
    }
    EXPECT_GT(reached, 5000);
}

TEST(GridVolume, FlightsBeginWithTheFirstSubstance) {
    GridCase grid{"slab", test::randomSamples({1, 1, 4}, 1, 1), {.filter = GridFilter::Nearest}};
    grid.samples.values = {0, 2, 0, 1};
    const MediumPtr medium = mediumOf(grid.volume());
    const auto at = [&](float target) {
        return medium->fly({0.5f, 0.5f, -1}, {0, 0, 1}, kInfinity, 0, target);
    };
    EXPECT_FLOAT_EQ(at(0)->distance, 1.25f);
    EXPECT_FLOAT_EQ(at(0.25f)->distance, 1.375f);
    EXPECT_FLOAT_EQ(at(0.5f)->distance, 1.75f) << "the thickness is exceeded beyond the empty part";
    EXPECT_FLOAT_EQ(at(0.7f)->distance, 1.95f);
    EXPECT_FALSE(at(0.75f));
    EXPECT_FALSE(medium->fly({0.5f, 0.5f, -1}, {0, 0, 1}, 1.25f, 0, 0));
    EXPECT_FALSE(medium->fly({0.5f, 0.5f, -1}, {0, 0, -1}, kInfinity, 0, 0));
}

TEST(GridVolume, ConstantIsHomogeneous) {
    const Rgb sigma(0.5f, 1.5f, 4);
    const MediumPtr homogeneous = makeHomogeneousMedium(sigma, Rgb(0.5f), makeIsotropicPhase());
    for (const Imath::V3i& resolution : {Imath::V3i(1), Imath::V3i(3, 50, 4)})
        for (const auto& [name, transform] : test::gridTransforms())
            for (const GridFilter filter : {GridFilter::Trilinear, GridFilter::Nearest}) {
                GridCase grid{name,
                              test::randomSamples(resolution, 3, 1),
                              {.filter = filter, .wrap = GridWrap::Repeat, .toWorld = transform}};
                for (size_t i = 0; i < grid.samples.values.size(); ++i)
                    grid.samples.values[i] = sigma[int(i % 3)];
                const MediumPtr medium = mediumOf(grid.volume());
                CounterRng rng(1);
                const auto inside = [&] {
                    return Vec3f(
                        transform.exactPoint({rng.nextDouble(), rng.nextDouble(), rng.nextDouble()}));
                };
                for (int i = 0; i < 30; ++i) {
                    const Vec3f a = inside(), b = inside(), direction = normalize(b - a);
                    const float length = (b - a).length();
                    const Rgb thickness = medium->thickness(a, direction, length);
                    for (int c = 0; c < 3; ++c) {
                        ASSERT_NEAR(thickness[c], sigma[c] * length, 1e-6f * sigma[c] * length);
                        const float target = rng.next1D() * 2;
                        const auto flight = medium->fly(a, direction, length, c, target),
                                   expected = homogeneous->fly(a, direction, length, c, target);
                        ASSERT_EQ(flight.has_value(), expected.has_value());
                        if (flight) {
                            ASSERT_NEAR(flight->distance, expected->distance, 1e-6f * expected->distance);
                        }
                    }
                    EXPECT_EQ(medium->scattering(a), homogeneous->scattering(a));
                }
            }
}

TEST(GridVolume, HalfEmptySpaceIsExactEitherSideOfBlocks) {
    // A sheet of one layer, wherever it lies between blocks.
    for (int layer = 0; layer < 40; ++layer) {
        GridCase grid{"sheet", test::randomSamples({1, 1, 40}, 1, 1), {}};
        std::fill(grid.samples.values.begin(), grid.samples.values.end(), 0.0f);
        grid.samples.values[size_t(layer)] = 3;
        const MediumPtr medium = mediumOf(grid.volume());
        EXPECT_NEAR(medium->thickness({0.5f, 0.5f, 2}, {0, 0, -1}, kInfinity).x, 3.0f / 40, 1e-6f) << layer;
    }
}

TEST(GridVolume, RefusesWhatIsNoDensity) {
    const auto message = [](GridSamples samples, const GridSettings& settings) -> std::string {
        try {
            makeGridVolume(std::move(samples), settings);
        } catch (const Error& error) {
            return error.what();
        }
        return "none";
    };
    const GridSamples good = test::randomSamples({4, 3, 2}, 3, 1);
    EXPECT_EQ(message(good, {}), "none");
    for (const float bad : {-1.0f, kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
        GridSamples samples = good;
        samples.values[size_t(((1 * 3 + 2) * 4 + 3) * 3 + 1)] = bad;
        EXPECT_THAT(message(samples, {}), testing::HasSubstr("in cell (3, 2, 1), channel 1"));
    }
    GridSamples samples = good;
    samples.values.pop_back();
    EXPECT_THAT(message(samples, {}), testing::HasSubstr("has 71 values, expected 4 x 3 x 2 of 3 channels"));
    samples = good;
    samples.channels = 2;
    EXPECT_THAT(message(samples, {}), testing::HasSubstr("2 channels, expected 1 or 3"));
    samples = good;
    samples.resolution.y = 0;
    EXPECT_THAT(message(samples, {}), testing::HasSubstr("0 samples along axis y"));
    samples.resolution = Imath::V3i(1 << 30);
    EXPECT_THAT(message(samples, {}), testing::HasSubstr("expected 1073741824 x"));
    GridSamples empty;
    EXPECT_THAT(message(empty, {}), testing::HasSubstr("has 0 values"));
    EXPECT_THAT(message(good, {.toWorld = Transform::scale({1, 0, 1})}),
                testing::HasSubstr("flattens space"));
    const double projective[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 1, 1}};
    EXPECT_THAT(message(good, {.toWorld = Transform::fromRows(projective)}), testing::HasSubstr("affine"));
    const Transform thin = Transform::rotate({0, 0, 1}, 45) * Transform::scale({1, 1e-6f, 1});
    EXPECT_THAT(message(good, {.wrap = GridWrap::Repeat, .toWorld = thin}),
                testing::HasSubstr("repeats itself"));
    EXPECT_EQ(message(good, {.toWorld = thin}), "none");
    EXPECT_THAT(message(test::randomSamples({4, 1, 4}, 1, 1), {.placement = GridPlacement::Nodes}),
                testing::HasSubstr("4 x 1 x 4 samples, expected two at least"));
    EXPECT_THAT(message(good, {.filter = GridFilter::Nearest, .placement = GridPlacement::Nodes}),
                testing::HasSubstr("linearly"));
}

}  // namespace
}  // namespace metrolux::core
