#include "integrators/pixel_importance.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

constexpr int kWidth = 40, kHeight = 20;
const FilmWindow kWindow{100, 100, 10, 5, kWidth, kHeight};

ReconstructionFilter box() { return {ReconstructionFilter::Kind::Box, {}}; }

/// An image of one pass. Left half 1, right half 9.
OwnImage halves() {
    Film film(kWindow, box());
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            film.addEye(uint32_t(y * kWidth + x), Rgb(x < kWidth / 2 ? 1.0f : 9.0f));
    OwnImage image(kWindow);
    image.addPass(film);
    return image;
}

SplatList pixelSplat(int x, int y, float value) {
    SplatList s;
    s.pixels.push_back({uint32_t(y * kWidth + x), Rgb(value)});
    return s;
}

TEST(PixelImportance, BeforeTheFirstPassIsLuminance) {
    PixelImportance importance;
    importance.update(OwnImage(kWindow), PixelImportance::kDarkestOfTarget);
    EXPECT_FLOAT_EQ(importance.size(pixelSplat(3, 3, 7)), 7);
}

TEST(PixelImportance, IsRelativeToTheImageAndKeepsTheScale) {
    PixelImportance importance;
    importance.update(halves(), PixelImportance::kDarkestOfTarget);
    // Mean 5, so that 0.5 is added to what is shown.
    const double left = importance.size(pixelSplat(5, 10, 1)), right = importance.size(pixelSplat(35, 10, 1));
    EXPECT_NEAR(left / right, 9.5 / 1.5, 1e-4);
    EXPECT_NEAR(0.5 * (left * 1 + right * 9), 5, 0.1);  // but for the blurred border of the halves
}

TEST(PixelImportance, OfFilmSplatsIsThatOfTheNearestPixel) {
    PixelImportance importance;
    importance.update(halves(), PixelImportance::kDarkestOfTarget);
    const auto at = [&](float x, float y) {
        SplatList s;
        s.film.push_back({{x, y}, Rgb(2.0f)});
        return importance.size(s);
    };
    EXPECT_FLOAT_EQ(at(15.5f, 15.5f), importance.size(pixelSplat(5, 10, 2)));
    EXPECT_FLOAT_EQ(at(8.0f, 4.0f), importance.size(pixelSplat(0, 0, 2)));  // the filter reaches in
    EXPECT_FLOAT_EQ(at(51.0f, 26.0f), importance.size(pixelSplat(kWidth - 1, kHeight - 1, 2)));
}

TEST(PixelImportance, OfABlackImageIsLuminance) {
    OwnImage image(kWindow);
    image.addPass(Film(kWindow, box()));
    PixelImportance importance;
    importance.update(image, PixelImportance::kDarkestOfTarget);
    EXPECT_FLOAT_EQ(importance.size(pixelSplat(3, 3, 7)), 7);
}

}  // namespace
}  // namespace metrolux::core
