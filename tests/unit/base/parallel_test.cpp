#include "base/parallel.h"

#include "base/error.h"

#include <gtest/gtest.h>

#include <vector>

namespace metrolux::core {
namespace {

TEST(ParallelFor, EveryIndexOnceAlsoInLoopsWithinLoops) {
    constexpr size_t kOuter = 37, kInner = 53;
    std::vector<int> visits(kOuter * kInner, 0);
    parallelFor(kOuter, [&](size_t i) { parallelFor(kInner, [&](size_t j) { ++visits[i * kInner + j]; }); });
    EXPECT_EQ(visits, std::vector<int>(kOuter * kInner, 1));
    parallelFor(0, [](size_t) { FAIL() << "there is no index"; });
}

TEST(ParallelFor, WhatABodyWroteIsThereAfterwards) {
    std::vector<size_t> values(1000);
    for (int round = 0; round < 20; ++round) {
        parallelFor(values.size(), [&](size_t i) { values[i] += i; });
        for (size_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], i * size_t(round + 1));
    }
}

TEST(ParallelFor, AnErrorOfABodyReachesTheCaller) {
    for (const size_t bad : {size_t{0}, size_t{63}, size_t{99}})
        EXPECT_THROW(parallelFor(100,
                                 [&](size_t i) {
                                     if (i == bad) throw Error("index {}", i);
                                 }),
                     Error);
}

}  // namespace
}  // namespace metrolux::core
