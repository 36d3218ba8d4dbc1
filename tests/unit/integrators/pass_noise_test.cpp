#include "integrators/pass_noise.h"

#include "base/rng.h"

#include <gtest/gtest.h>

#include <cmath>

namespace metrolux::core {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr size_t kPixels = size_t{kWidth} * kHeight;
const FilmWindow kWindow{kWidth, kHeight, 0, 0, kWidth, kHeight};

/// Passes whose pixels are 1 +- `spread`, while eye subpaths alone find 1 +- `eyeSpread`.
struct Passes {
    Film film{kWindow, {ReconstructionFilter::Kind::Box, {}}};
    EyeFactors eyes{kWindow};
    OwnImage image{kWindow};
    PixelImportance importance;
    PassNoise noise{kPixels};
    CounterRng rng{5};

    void add(float spread, float eyeSpread) {
        const auto sign = [&] { return rng.next1D() < 0.5f ? -1.0f : 1.0f; };
        for (uint32_t i = 0; i < kPixels; ++i) {
            film.addEye(i, Rgb(1 + spread * sign()));
            eyes.set(i, {0, 0.5f, 0.5f + eyeSpread * sign(), 0});
        }
        image.addPass(film);
        film.endPass();
        eyes.endPass();
        noise.addEyes(eyes);
    }
    void judge(int passes, float spread, float eyeSpread) {
        for (int i = 0; i < passes; ++i) {
            importance.update(image, PixelImportance::kDarkestOfTarget);
            noise.begin(eyes, importance, 0, 1);
            add(spread, eyeSpread);
            noise.close(image, {1000, 1000, 0, 0});
        }
    }
    PassNoise::Verdict verdict(bool uniform = true, const Surprise& surprise = {}) {
        importance.update(image, PixelImportance::kDarkestOfTarget);
        return noise.verdict(image, importance, uniform, surprise);
    }
};

// The mean over 3072 pixels of n differences of two signs has a relative standard deviation of sqrt(1 / (3072
// n)), a little more for dependent neighbors: 8 % are more than 5 of them. Importance is 1 / 1.1 of what is
// shown, scaled to a mean of 1.

TEST(PassNoise, IsTheVarianceOfAPassAndOfItsEyeSubpaths) {
    Passes p;
    p.judge(4, 0.1f, 0.2f);
    const PassNoise::Verdict v = p.verdict();
    EXPECT_NEAR(v.noise, 0.01, 0.0008);
    EXPECT_NEAR(v.aloneNoise, 0.04, 0.0032);
    EXPECT_NEAR(v.allNoise, 0.01, 0.0008);
}

TEST(PassNoise, ComparesTheHalvesWhereThereAreEnoughPasses) {
    Passes p;
    p.judge(4, 0.1f, 0.2f);
    p.noise.end();
    for (int i = 0; i < 4; ++i) p.add(0.1f, 0.2f);
    p.noise.noteHalf(p.image);
    for (int i = 0; i < 8; ++i) p.add(0.1f, 0.2f);
    p.judge(2, 0.3f, 0.2f);  // two noisier ones
    // Half the passes have 0.01, 8 have it and 2 have 0.09 in the others.
    const double rest = (8 * 0.01 + 2 * 0.09) / 100, first = 0.01 / 8, scale = 1 / (1.0 / 8 + 1.0 / 10);
    EXPECT_NEAR(p.verdict().noise, scale * (first + rest), 0.1 * scale * (first + rest));
    EXPECT_NEAR(p.verdict().aloneNoise, 0.04, 0.004);
    EXPECT_NEAR(p.verdict(false).noise, 0.09, 0.009) << "of the judged passes";
}

TEST(PassNoise, LeavesOutTheWorstPixels) {
    Passes p;
    p.judge(4, 0.1f, 0.2f);
    // Three of 3072 pixels are far off in a fifth pass.
    p.importance.update(p.image, PixelImportance::kDarkestOfTarget);
    p.noise.begin(p.eyes, p.importance, 0, 1);
    for (const uint32_t i : {700u, 1400u, 2100u}) p.film.addEye(i, Rgb(100.0f));
    p.add(0.1f, 0.2f);
    p.noise.close(p.image, {1000, 1000, 0, 0});
    EXPECT_NEAR(p.verdict().noise, 0.01, 0.001);
    EXPECT_GT(p.verdict().allNoise, 0.02);
}

TEST(PassNoise, EyeSubpathsAloneWinByNoiseTimesWork) {
    PassNoise::Verdict v;
    v.noise = v.allNoise = 1;
    v.aloneNoise = v.aloneAllNoise = 2;
    v.eyeShare = 0.4;
    EXPECT_LT(v.lossOfAlone(), 1);
    v.eyeShare = 0.7;
    EXPECT_GT(v.lossOfAlone(), 1);
    v.eyeShare = 0.4;
    v.surprise = {4, 0};  // noise that they have not met yet
    EXPECT_GT(v.lossOfAlone(), 1);
    v.surprise = {4, 3};  // and that light subpaths do not take away
    EXPECT_LT(v.lossOfAlone(), 1);
    EXPECT_EQ(PassNoise::Verdict{}.lossOfAlone(), 1) << "nothing is known";
}

TEST(PassWork, EyeSubpathsHaveLessOfAPassTheMoreLightSubpathsDo) {
    const PassWork eyes{1000, 0, 0, 0}, few{1000, 500, 0, 0}, many{1000, 500, 1000, 9000};
    EXPECT_LE(eyes.eyeShare(), 1);
    EXPECT_LT(few.eyeShare(), eyes.eyeShare());
    EXPECT_LT(many.eyeShare(), few.eyeShare());
    EXPECT_EQ(PassWork{}.eyeShare(), 1);
}

}  // namespace
}  // namespace metrolux::core
