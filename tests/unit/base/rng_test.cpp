#include "base/rng.h"

#include "support/goodness_of_fit.h"

#include <gtest/gtest.h>

#include <set>

namespace metrolux::core {
namespace {

using test::chiSquarePValue;
using test::kLevel;

TEST(Rng, AValueDependsOnKeyAndCounterOnly) {
    CounterRng a(42), b(42);
    for (int i = 0; i < 10; ++i) a.nextBits();
    const uint64_t eleventh = a.nextBits();
    b.seek(10);
    EXPECT_EQ(b.nextBits(), eleventh);
    EXPECT_EQ(b.counter(), 11u);
    EXPECT_EQ(CounterRng(42, 10).nextBits(), eleventh);
}

TEST(Rng, NumbersStayBelowOne) {
    EXPECT_EQ(toUnitFloat(0), 0);
    EXPECT_EQ(toUnitFloat(~uint64_t(0)), kOneMinusEpsilon);
    CounterRng rng(1);
    for (int i = 0; i < 100000; ++i) {
        const double d = rng.nextDouble();
        ASSERT_TRUE(d >= 0 && d < 1);
    }
}

TEST(Rng, WordsAndTheirOrderMakeTheKey) {
    EXPECT_NE(hashKey(1, 2), hashKey(2, 1));
    EXPECT_NE(hashKey(1), hashKey(1, 0));
    EXPECT_NE(hashKey(0), hashKey(0, 0));
    std::set<uint64_t> keys;
    for (int seed = 0; seed < 8; ++seed)
        for (int x = 0; x < 64; ++x)
            for (int y = 0; y < 64; ++y) keys.insert(hashKey(seed, x, y));
    EXPECT_EQ(keys.size(), 8u * 64 * 64);
}

TEST(Rng, OneFlippedBitChangesHalfOfTheHash) {
    CounterRng rng(3);
    double flipped = 0;
    constexpr int kTrials = 2000;
    for (int i = 0; i < kTrials; ++i) {
        const uint64_t x = rng.nextBits();
        flipped += __builtin_popcountll(hashKey(x) ^ hashKey(x ^ (uint64_t(1) << (i % 64))));
    }
    const double bits = 64.0 * kTrials;
    EXPECT_GT(test::normalPValue((flipped - bits / 2) / std::sqrt(bits / 4)), kLevel);
}

/// Pairs of numbers on a 32 x 32 grid.
template <class Pair>
double uniformityOfPairs(Pair&& pair) {
    constexpr int kBins = 32;
    std::vector<double> counts(kBins * kBins);
    for (int i = 0; i < 200000; ++i) {
        const Vec2f p = pair(i);
        counts[static_cast<int>(p.y * kBins) * kBins + static_cast<int>(p.x * kBins)] += 1;
    }
    return chiSquarePValue(counts);
}

TEST(Rng, PairsAreUniformWithinAStreamAndAcrossStreams) {
    CounterRng stream(5);
    EXPECT_GT(uniformityOfPairs([&](int) { return stream.next2D(); }), kLevel);
    EXPECT_GT(uniformityOfPairs([&](int) {
                  const float x = stream.next1D();
                  return Vec2f(x, stream.next1D());
              }),
              kLevel);
    // First numbers of streams with neighboring keys, and equal positions of two streams.
    EXPECT_GT(uniformityOfPairs([](int i) {
                  return Vec2f(CounterRng(hashKey(7, i)).next1D(), CounterRng(hashKey(7, i + 1)).next1D());
              }),
              kLevel);
    CounterRng a(hashKey(1)), b(hashKey(2));
    EXPECT_GT(uniformityOfPairs([&](int) { return Vec2f(a.next1D(), b.next1D()); }), kLevel);
    // Keys that differ in the low bits only, not hashed: what a careless caller does.
    EXPECT_GT(
        uniformityOfPairs([](int i) { return Vec2f(CounterRng(i).next1D(), CounterRng(i + 1).next1D()); }),
        kLevel);
}

TEST(Rng, LowBitsAreAsGoodAsHighOnes) {
    CounterRng rng(9);
    std::vector<double> counts(64);
    constexpr int kTrials = 50000;
    for (int i = 0; i < kTrials; ++i) {
        const uint64_t x = rng.nextBits();
        for (int bit = 0; bit < 64; ++bit) counts[bit] += (x >> bit) & 1;
    }
    for (const double c : counts)
        EXPECT_GT(test::normalPValue((c - kTrials / 2.0) / std::sqrt(kTrials / 4.0)), kLevel);
}

}  // namespace
}  // namespace metrolux::core
