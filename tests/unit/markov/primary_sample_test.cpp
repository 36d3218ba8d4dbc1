#include "markov/primary_sample.h"

#include "support/goodness_of_fit.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

TEST(PrimarySampleStream, GrowthKeepsTheCoordinatesThatAreThere) {
    PrimarySample u = {0.1f, 0.2f, 0.3f};
    CounterRng rng(1);
    PrimarySampleStream stream(u, rng);
    EXPECT_EQ(stream.next1D(), 0.1f);
    EXPECT_EQ(stream.next2D(), Vec2f(0.2f, 0.3f));
    const float fourth = stream.next1D();
    ASSERT_EQ(u.size(), 4u);
    EXPECT_EQ(u[3], fourth);

    // A block further on: the gap is filled, and read later as it was filled.
    stream.seek(3);
    const float far = stream.next1D();
    ASSERT_EQ(u.size(), size_t(SampleStream::blockOffset(3)) + 1);
    const PrimarySample grown = u;
    EXPECT_EQ(PrimarySample(u.begin(), u.begin() + 4), (PrimarySample{0.1f, 0.2f, 0.3f, fourth}));
    EXPECT_EQ(u.back(), far);
    for (int block : {2, 0, 1, 3}) {
        stream.seek(block);
        EXPECT_EQ(stream.next1D(), grown[SampleStream::blockOffset(block)]);
    }
    EXPECT_EQ(u, grown);
}

TEST(PrimarySampleStream, ReadsWithoutDrawingWhenNothingIsMissing) {
    PrimarySample u(SampleStream::blockOffset(4), 0.5f);
    CounterRng rng(2);
    PrimarySampleStream stream(u, rng);
    for (int block = 0; block < 4; ++block) {
        stream.seek(block);
        stream.next2D();
        stream.next2D();
    }
    EXPECT_EQ(rng.counter(), 0u);
}

TEST(PrimarySampleStream, NewCoordinatesAreUniform) {
    constexpr int kBins = 20;
    CounterRng rng(3);
    std::vector<double> counts(kBins * kBins);
    for (int i = 0; i < 100000; ++i) {
        PrimarySample u;
        PrimarySampleStream stream(u, rng);
        stream.seek(i % 5);
        const Vec2f p = stream.next2D();
        counts[static_cast<int>(p.y * kBins) * kBins + static_cast<int>(p.x * kBins)] += 1;
    }
    EXPECT_GT(test::chiSquarePValue(counts), test::kLevel);
}

}  // namespace
}  // namespace metrolux::core
