#include "transport/technique.h"

#include "base/parallel.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

TEST(NonFiniteCounts, CountWhatTheyRejectFromAllThreads) {
    NonFiniteCounts counts;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    parallelFor(1000, [&](size_t i) {
        EXPECT_FALSE(counts.reject(Rgb(1, 2, 3), Technique::Hit));
        EXPECT_TRUE(counts.reject(Rgb(1, nan, 3), Technique::Nee));
        const Rgb value(i % 2 == 1 ? -kInfinity : 0.0f, 0, 0);
        EXPECT_EQ(counts.finite(value, Technique::Merge), Rgb(0.0f));
        EXPECT_EQ(counts.finite(Rgb(4, 5, 6), Technique::Merge), Rgb(4, 5, 6));
    });
    counts.add(Technique::Splat, 3);
    EXPECT_EQ(counts.counts(), (TechniqueCounts{0, 1000, 0, 3, 500}));
    TechniqueCounts sum{1, 1, 1, 1, 1};
    sum += counts.counts();
    EXPECT_EQ(sum, (TechniqueCounts{1, 1001, 1, 4, 501}));
    EXPECT_STREQ(techniqueName(Technique::Hit), "hit");
    EXPECT_STREQ(techniqueName(Technique::Merge), "merge");
}

}  // namespace
}  // namespace metrolux::core
