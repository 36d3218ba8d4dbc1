#include "integrators/light_subpath_noise.h"

#include "base/rng.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

constexpr int kSide = 32;
constexpr size_t kPixels = size_t{kSide} * kSide;
const FilmWindow kWindow{kSide, kSide, 0, 0, kSide, kSide};

/// Light subpaths that add `value` to a random pixel, in runs of `repeats` equal ones, as a chain that is
/// slow to move. On average a pixel shows 1.
struct Toy {
    explicit Toy(int equal, ReconstructionFilter::Kind filter = ReconstructionFilter::Kind::Box,
                 bool onFilm = false)
        : repeats(equal), filmSplats(onFilm), film(kWindow, {filter, {}}) {}

    int repeats;
    bool filmSplats;
    Film film;
    OwnImage image{kWindow};
    PixelImportance importance;
    LightSubpathNoise noise{kPixels};
    CounterRng rng{3};

    void pass() {
        importance.update(image, PixelImportance::kDarkestOfNoise);
        // What eye subpaths have added before is no light subpath's.
        for (uint32_t i = 0; i < kPixels; ++i) film.addEye(i, Rgb(rng.next1D()));
        noise.beginIteration(film);
        const int samples = 4 * int(kPixels);
        const double ofFilm = film.filter().squaredWeights();
        double squares = 0;
        for (int i = 0; i < samples; i += repeats) {
            SplatList splats;
            if (filmSplats)
                splats.film.push_back({{kSide * rng.next1D(), kSide * rng.next1D()}, Rgb(float(kPixels))});
            else
                splats.pixels.push_back({uint32_t(rng.next1D() * kPixels), Rgb(float(kPixels))});
            film.addSplats(splats, double(repeats) / samples);
            squares += repeats * importance.squares(splats, ofFilm) / samples;
        }
        noise.endIteration(film, squares, samples);
        image.addPass(film);
        film.endPass();
        noise.endPass(importance);
    }
    double gain() {
        for (int i = 0; i < 12; ++i) pass();
        return noise.gain();
    }
};

// Each pixel has four splats a pass, or groups of them: a variance over 11 differences of 1024 pixels is
// known to a few percent, but those of few groups, which have heavy tails, to a tenth.

TEST(LightSubpathNoise, IsThatOfIndependentOnesIfTheyAre) { EXPECT_NEAR(Toy{1}.gain(), 1, 0.1); }

TEST(LightSubpathNoise, FindsHowMuchAChainRepeatsItself) { EXPECT_NEAR(Toy{8}.gain(), 1.0 / 8, 0.03); }

TEST(LightSubpathNoise, KnowsThatTheFilterSpreadsFilmSplats) {
    Toy toy{1, ReconstructionFilter::Kind::Gaussian, true};
    EXPECT_NEAR(toy.gain(), 1, 0.1);
}

TEST(LightSubpathNoise, IsNotKnownBeforeTwoPasses) {
    Toy toy{8};
    EXPECT_EQ(toy.noise.gain(), 1);
    toy.pass();
    EXPECT_EQ(toy.noise.gain(), 1);
    toy.pass();
    EXPECT_LT(toy.noise.gain(), 0.5);
}

TEST(LightSubpathNoise, ComparesNoPassesWithOthersBetween) {
    Toy toy{8};
    toy.gain();
    const double before = toy.noise.gain();
    toy.noise.end();
    toy.film.endPass();
    toy.repeats = 1;
    toy.pass();
    // One more prediction, but no difference.
    EXPECT_NEAR(toy.noise.gain() / before, 1, 0.05);
}

}  // namespace
}  // namespace metrolux::core
