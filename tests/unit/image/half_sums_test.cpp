#include "image/half_sums.h"

#include "base/error.h"
#include "base/state_archive.h"

#include <gtest/gtest.h>

#include <string>

namespace metrolux::core {
namespace {

const FilmWindow kWindow{2, 1, 0, 0, 2, 1};

Film makeFilm() { return {kWindow, ReconstructionFilter(ReconstructionFilter::Kind::Box, {})}; }

/// A pass of this value in the first pixel, and twice that in the second.
void addPass(Film& film, HalfSums& halves, bool first, float value) {
    halves.enter(first, film);
    film.addEye(0, Rgb(value));
    film.addEye(1, Rgb(2 * value));
    film.endPass();
}

TEST(HalfSums, BlocksGrow) {
    std::string pattern;
    for (uint32_t pass = 0; pass < 32; ++pass) pattern += isOfFirstHalf(pass) ? 'A' : 'B';
    EXPECT_EQ(pattern, "ABBAABBAAABBBBAAAAAABBBBBBBBAAAA");
}

TEST(HalfSums, NoHalfIsSmall) {
    uint32_t first = 0;
    for (uint32_t pass = 0; pass < 100000; ++pass) {
        first += isOfFirstHalf(pass);
        const uint32_t passes = pass + 1;
        if (passes < 2) continue;
        ASSERT_GE(3 * first, passes) << passes;
        ASSERT_LE(3 * first, 2 * passes) << passes;
        const bool isPowerOfTwo = (passes & pass) == 0;
        ASSERT_TRUE(!isPowerOfTwo || 2 * first == passes) << passes;
    }
}

TEST(HalfSums, MeansOfTheHalves) {
    Film film = makeFilm();
    HalfSums halves(2);
    const bool first[] = {true, false, false, true, true};
    const float values[] = {1, 10, 20, 3, 5};
    for (size_t i = 0; i < 5; ++i) addPass(film, halves, first[i], values[i]);
    halves.close(film);
    const auto [a, b] = halves.means(film);
    EXPECT_FLOAT_EQ(a[0], 3);
    EXPECT_FLOAT_EQ(a[5], 6);
    EXPECT_FLOAT_EQ(b[0], 15);
    EXPECT_FLOAT_EQ(b[5], 30);
    EXPECT_EQ(halves.firstPasses(), 3u);
}

TEST(HalfSums, ClosedSavedAndAddedTheyAreTheSame) {
    Film whole = makeFilm(), early = makeFilm(), late = makeFilm();
    HalfSums wholeHalves(2), earlyHalves(2), lateHalves(2);
    for (uint32_t pass = 0; pass < 12; ++pass) {
        const float value = 1 / (1.0f + static_cast<float>(pass));
        addPass(whole, wholeHalves, isOfFirstHalf(pass), value);
        addPass(pass < 5 ? early : late, pass < 5 ? earlyHalves : lateHalves, isOfFirstHalf(pass), value);
        if (pass == 8) {
            lateHalves.close(late);
            const std::string bytes = saveState(lateHalves);
            lateHalves = HalfSums(2);
            loadState(bytes, lateHalves);
        }
    }
    wholeHalves.close(whole);
    earlyHalves.close(early);
    lateHalves.close(late);
    lateHalves.add(earlyHalves);
    late.add(early);
    EXPECT_EQ(lateHalves.means(late), wholeHalves.means(whole));
    EXPECT_THROW(lateHalves.add(HalfSums(3)), Error);
}

}  // namespace
}  // namespace metrolux::core
