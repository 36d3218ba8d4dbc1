#include "image/compare.h"

#include "base/error.h"
#include "base/rng.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

ImageData constant(int width, int height, float value) {
    return {width, height, 3, std::vector<float>(static_cast<size_t>(width * height * 3), value)};
}

TEST(Compare, KnownNumbers) {
    const ImageDifference d = compareImages(constant(40, 40, 3), constant(40, 40, 2));
    EXPECT_NEAR(d.mse, 1, 1e-12);
    EXPECT_NEAR(d.relMse, 1 / 4.01, 1e-12);
    EXPECT_NEAR(d.trimmedRelMse, 1 / 4.01, 1e-12);
    EXPECT_NEAR(d.smape, 0.4, 1e-12);
    EXPECT_NEAR(d.bias, 0.5, 1e-12);
    EXPECT_NEAR(d.biasError, 0, 1e-12);
    EXPECT_EQ(d.pixels, 1600u);
}

TEST(Compare, EqualImagesDoNotDiffer) {
    const ImageDifference d = compareImages(constant(3, 3, 0), constant(3, 3, 0));
    EXPECT_EQ(d.mse, 0);
    EXPECT_EQ(d.relMse, 0);
    EXPECT_EQ(d.smape, 0);
}

TEST(Compare, TrimmingDropsTheFirefly) {
    ImageData a = constant(50, 40, 1.1f);
    for (size_t i = 300; i < 306; ++i) a.pixels[i] = 1e4f;  // two pixels: 0.1 % of 2000
    const ImageDifference d = compareImages(a, constant(50, 40, 1));
    EXPECT_GT(d.relMse, 1e4);
    EXPECT_NEAR(d.trimmedRelMse, 0.01 / 1.01, 1e-6);
}

TEST(Compare, BiasErrorCoversTheNoise) {
    // 400 pairs with independent noise and no bias: |bias| < 2 biasError in about 95 % of them (binomial, 6
    // sigma).
    CounterRng rng(11);
    int covered = 0;
    const int runs = 400;
    for (int run = 0; run < runs; ++run) {
        ImageData a = constant(96, 96, 1);
        for (float& value : a.pixels) value += rng.next1D() - 0.5f;
        const ImageDifference d = compareImages(a, constant(96, 96, 1));
        covered += std::abs(d.bias) < 2 * d.biasError;
    }
    EXPECT_NEAR(covered, 0.947 * runs, 6 * std::sqrt(0.053 * runs));
}

TEST(Compare, NonFinitePixelsAreCountedAndLeftOut) {
    ImageData a = constant(20, 20, 1);
    a.pixels[30] = std::numeric_limits<float>::quiet_NaN();
    a.pixels[60] = kInfinity;
    const ImageDifference d = compareImages(a, constant(20, 20, 1));
    EXPECT_EQ(d.nonFinite, 2u);
    EXPECT_EQ(d.pixels, 398u);
    EXPECT_EQ(d.mse, 0);
}

TEST(Compare, AlphaIsLeftOutAndGrayIsThreeChannels) {
    const ImageData gray{2, 1, 1, {1, 2}};
    const ImageData rgba{2, 1, 4, {1, 1, 1, 0.3f, 2, 2, 2, 0.7f}};
    EXPECT_EQ(compareImages(gray, rgba).mse, 0);
}

TEST(Compare, SizesMustAgree) {
    EXPECT_THROW(compareImages(constant(2, 3, 1), constant(3, 2, 1)), Error);
    EXPECT_THROW(errorHeatMap(constant(2, 3, 1), constant(3, 2, 1)), Error);
}

TEST(Compare, HeatMapRunsFromBlackToWhite) {
    ImageData a{3, 1, 3, {1, 1, 1, 50, 50, 50, std::numeric_limits<float>::quiet_NaN(), 0, 0}};
    const ImageData map = errorHeatMap(a, constant(3, 1, 1));
    EXPECT_EQ(map.pixels, (std::vector<float>{0, 0, 0, 1, 1, 1, 0, 1, 0}));
}

}  // namespace
}  // namespace metrolux::core
