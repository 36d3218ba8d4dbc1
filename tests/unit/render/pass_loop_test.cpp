#include "render/pass_loop.h"

#include "base/error.h"
#include "base/rng.h"
#include "fakes.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// A film of 4x4 pixels and a clock that advances with each pass.
struct PassLoop : testing::Test {
    Film film{{4, 4, 0, 0, 4, 4}, ReconstructionFilter(ReconstructionFilter::Kind::Box, {})};
    test::FakeIntegrator integrator;
    double secondsPerPass = 1;
    std::vector<PassReport> reports;
    PassLoopHooks hooks;

    PassLoop() {
        hooks.clock = [this] { return 100 + secondsPerPass * film.passes(); };
        hooks.afterPass = [this](const PassReport& report) { reports.push_back(report); };
    }
};

TEST_F(PassLoop, StopsAfterPasses) {
    EXPECT_EQ(renderPasses(integrator, film, {0, 5, 0}, hooks), StopReason::Passes);
    EXPECT_EQ(film.passes(), 5u);
    ASSERT_EQ(reports.size(), 5u);
    EXPECT_EQ(reports[1].passes, 2u);
    EXPECT_DOUBLE_EQ(reports[1].seconds, 2);
    EXPECT_DOUBLE_EQ(reports[1].secondsRemaining, 3);
}

TEST_F(PassLoop, StopsAtTheTimeNearestToTheLimit) {
    secondsPerPass = 3;
    EXPECT_EQ(renderPasses(integrator, film, {10, 0, 0}, hooks), StopReason::Time);
    EXPECT_EQ(film.passes(), 3u);  // 9 s are nearer to 10 s than 12 s
    EXPECT_DOUBLE_EQ(reports[0].secondsRemaining, 7);
}

TEST_F(PassLoop, RendersOnePassEvenIfItIsTooLong) {
    secondsPerPass = 1000;
    EXPECT_EQ(renderPasses(integrator, film, {10, 0, 0}, hooks), StopReason::Time);
    EXPECT_EQ(film.passes(), 1u);
}

TEST_F(PassLoop, StopsWhenTheErrorIsSmallEnough) {
    CounterRng rng(4);
    test::FakeIntegrator noisy([&rng](uint32_t) { return 0.5f + rng.next1D(); });
    EXPECT_EQ(renderPasses(noisy, film, {0, 100000, 0.02}, hooks), StopReason::Error);
    EXPECT_LE(film.relativeError(), 0.02);
    // Relative deviation of a pass is 0.29: about 200 passes. All pixels are equal here, so the estimate is a
    // rough one.
    EXPECT_GT(film.passes(), 60u);
    EXPECT_LT(film.passes(), 1000u);
}

TEST_F(PassLoop, FirstLimitCounts) {
    EXPECT_EQ(renderPasses(integrator, film, {1000, 3, 0}, hooks), StopReason::Passes);
    EXPECT_EQ(renderPasses(integrator, film, {2, 1000, 0}, hooks), StopReason::Time);
}

TEST_F(PassLoop, EndsWhenTheFilmTakesNoMorePasses) {
    film.addSums(std::vector<PixelSum>(16), Film::kMostPasses - 2);
    EXPECT_EQ(renderPasses(integrator, film, {0, 0, 1e-9}, hooks), StopReason::Full);
    EXPECT_EQ(reports.size(), 2u);
}

TEST_F(PassLoop, InterruptEndsThePassInProgress) {
    hooks.interrupted = [this] { return film.passes() >= 2; };
    EXPECT_EQ(renderPasses(integrator, film, {0, 100, 0}, hooks), StopReason::Interrupted);
    EXPECT_EQ(film.passes(), 2u);
    EXPECT_EQ(reports.size(), 2u);
}

TEST_F(PassLoop, NeedsALimit) { EXPECT_THROW(renderPasses(integrator, film, {}, hooks), Error); }

}  // namespace
}  // namespace metrolux::core
