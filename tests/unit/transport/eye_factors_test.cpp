#include "transport/eye_factors.h"

#include "base/rng.h"
#include "support/eye_factors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace metrolux::core {
namespace {

constexpr int kWidth = 40, kHeight = 20;  // not a multiple of the tiles
const FilmWindow kWindow{100, 80, 30, 16, kWidth, kHeight};

/// Passes whose estimates for paths with one smooth vertex are 1 +- `spread` on the left half of the film,
/// and 0 or twice the mean on the right; those with two are 0, with more like the left half.
EyeFactors afterPasses(int passes, float spread) {
    EyeFactors factors(kWindow);
    CounterRng rng(3);
    for (int pass = 0; pass < passes; ++pass) {
        for (uint32_t pixel = 0; pixel < kWidth * kHeight; ++pixel) {
            const float narrow = 1 + spread * (rng.next1D() < 0.5f ? -1 : 1);
            const float wide = rng.next1D() < 0.5f ? 0 : 2;
            factors.set(pixel, {0, pixel % kWidth < kWidth / 2 ? narrow : wide, 0, narrow});
        }
        factors.endPass();
    }
    return factors;
}

TEST(EyeFactors, AreSecondMomentOverVariance) {
    const EyeFactors factors = afterPasses(100, 0.25f);
    const uint16_t left = factors.regionOf({31, 17}), right = factors.regionOf({68, 17});
    EXPECT_NE(left, right);
    // Var 1/16, second moment 17/16; 16 differences of 64 pixels at least, for each of 99 passes: 4 %.
    EXPECT_NEAR(factors.at({left, 1}), 17, 0.7);
    EXPECT_NEAR(factors.at({right, 1}), 2, 0.1);  // var 1, second moment 2
    EXPECT_EQ(factors.at({left, 2}), 1);          // nothing is found on such paths
    EXPECT_EQ(factors.at({left, 0}), 1);
    EXPECT_EQ(factors.at({left, 3}), factors.at({left, 9}));
    EXPECT_EQ(factors.at({left, 3}), 4);  // the most for indirect light
}

TEST(EyeFactors, AreOneUntilTwoPassesAreKnown) {
    const EyeFactors factors = afterPasses(1, 0.25f);
    for (int smooth = 0; smooth < 5; ++smooth) EXPECT_EQ(factors.at({factors.regionOf({40, 20}), smooth}), 1);
}

TEST(EyeFactors, AreBoundedWhereNothingVaries) {
    const EyeFactors factors = afterPasses(400, 0);
    EXPECT_EQ(factors.at({factors.regionOf({31, 17}), 1}), 64);
}

TEST(EyeFactors, ARegionIsAPlaceOfTheFilm) {
    const EyeFactors factors(kWindow);
    EXPECT_EQ(factors.regionOf({30, 16}), factors.regionOf({37.9f, 23.9f}));
    EXPECT_NE(factors.regionOf({37.9f, 16}), factors.regionOf({38.1f, 16}));
    // Filters reach beyond the window: the nearest tile.
    EXPECT_EQ(factors.regionOf({12, 3}), factors.regionOf({30, 16}));
    EXPECT_EQ(factors.regionOf({99, 79}), factors.regionOf({69.5f, 35.5f}));
}

TEST(EyeFactors, LargeFilmsHaveNoMoreRegionsThanTheirNamesTell) {
    const FilmWindow large{16000, 9000, 0, 0, 16000, 9000};
    // Only the constructor's arithmetic matters: regions of the corners differ and are in range.
    const EyeFactors factors(large);
    EXPECT_EQ(factors.regionOf({0, 0}), 0);
    EXPECT_GT(factors.regionOf({15999, 8999}), 30000);
    EXPECT_LT(factors.at({factors.regionOf({15999, 8999}), 1}), 2);
}

}  // namespace
}  // namespace metrolux::core
