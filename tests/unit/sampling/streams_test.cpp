#include "sampling/streams.h"

#include "sampling/sobol.h"
#include "support/goodness_of_fit.h"

#include <gtest/gtest.h>

#include <set>

namespace metrolux::core {
namespace {

using test::chiSquarePValue;
using test::kLevel;
using test::normalPValue;

/// All coordinates of the first blocks, each as it comes after a seek.
template <class Stream>
std::vector<float> readBlocks(Stream&& stream, const std::vector<int>& blocks) {
    std::vector<float> result;
    for (const int block : blocks) {
        stream.seek(block);
        for (int i = 0; i < SampleStream::kVertexBlock; ++i) result.push_back(stream.next1D());
    }
    return result;
}

TEST(SampleStream, BlocksDoNotOverlap) {
    EXPECT_EQ(SampleStream::blockOffset(0), 0);
    EXPECT_EQ(SampleStream::blockOffset(1), SampleStream::kEndpointBlock);
    for (int block = 1; block < 100; ++block)
        EXPECT_EQ(SampleStream::blockOffset(block + 1) - SampleStream::blockOffset(block),
                  SampleStream::kVertexBlock);
}

TEST(IndependentStream, SeekReproducesACoordinateFromAnywhere) {
    IndependentStream a(99), b(99);
    const std::vector<float> forth = readBlocks(a, {1, 2, 3, 7});
    const std::vector<float> back = readBlocks(b, {7, 3, 2, 1});
    for (int block = 0; block < 4; ++block)
        for (int i = 0; i < 4; ++i) EXPECT_EQ(forth[block * 4 + i], back[(3 - block) * 4 + i]);
    // Running on from one block arrives at the next.
    a.seek(0);
    for (int i = 0; i < SampleStream::kEndpointBlock; ++i) a.next1D();
    EXPECT_EQ(a.next1D(), forth[0]);
    // Pairs are two single coordinates: a primary sample can hold them.
    a.seek(2);
    const Vec2f pair = a.next2D();
    EXPECT_EQ(pair, Vec2f(forth[4], forth[5]));
}

TEST(SobolStream, ManyAtOnceGiveTheSameNumbers) {
    constexpr uint32_t kIndex = 1234567;
    constexpr size_t kStreams = 37;  // not whole vectors
    std::vector<uint64_t> keyHashes;
    for (uint64_t key = 0; key < kStreams; ++key) keyHashes.push_back(hashKey(key));
    std::vector<float> single(kStreams), x(kStreams), y(kStreams);
    const auto first = static_cast<uint64_t>(SampleStream::blockOffset(3));
    sobol::points1D(keyHashes, sobol::reverseBits(kIndex), first, single.data());
    sobol::points2D(keyHashes, sobol::reverseBits(kIndex), first + 1, x.data(), y.data());
    for (size_t i = 0; i < kStreams; ++i) {
        SobolStream stream(i, kIndex);
        stream.seek(3);
        EXPECT_EQ(single[i], stream.next1D());
        EXPECT_EQ(Vec2f(x[i], y[i]), stream.next2D());
    }
}

/// By the recurrence of the direction numbers.
uint32_t sobolSecondByDefinition(uint32_t index) {
    uint32_t result = 0;
    for (uint32_t v = 1; index != 0; index >>= 1, v ^= v << 1)
        if (index & 1u) result ^= v;
    return result;
}

TEST(SobolStream, SecondDimensionIsSobols) {
    // The first eight points are 0, 1/2, 3/4, 1/4, 5/8, 1/8, 3/8, 7/8.
    const uint32_t eighths[] = {0, 1, 3, 2, 5, 4, 6, 7};
    for (uint32_t i = 0; i < 8; ++i) EXPECT_EQ(sobol::secondReversed(i), eighths[i]) << i;
    CounterRng rng(hashKey(77));
    for (int i = 0; i < 10000; ++i) {
        const auto index = static_cast<uint32_t>(rng.nextBits());
        ASSERT_EQ(sobol::secondReversed(index), sobolSecondByDefinition(index)) << index;
    }
}

template <class Stream>
void expectSkipPassesOver(Stream&& skipping, Stream&& reading) {
    skipping.seek(0);
    reading.seek(0);
    for (const int count : {1, 5, 0, 6}) {
        skipping.skip(count);
        for (int i = 0; i < count; ++i) reading.next1D();
        ASSERT_EQ(skipping.next1D(), reading.next1D());
    }
}

TEST(SampleStream, SkippedCoordinatesAreAsIfRead) {
    expectSkipPassesOver(IndependentStream(5), IndependentStream(5));
    expectSkipPassesOver(SobolStream(5, 9), SobolStream(5, 9));
    SobolStream a(6, 1), b(6, 1);
    expectSkipPassesOver(InterleavedStream(a, 1, 3), InterleavedStream(b, 1, 3));
}

TEST(SobolStream, SeekReproducesACoordinateFromAnywhere) {
    SobolStream a(99, 5), b(99, 5);
    const std::vector<float> forth = readBlocks(a, {1, 2, 3, 7}), back = readBlocks(b, {7, 3, 2, 1});
    for (int block = 0; block < 4; ++block)
        for (int i = 0; i < 4; ++i) EXPECT_EQ(forth[block * 4 + i], back[(3 - block) * 4 + i]);
    // A pair takes the room of two coordinates.
    a.seek(1);
    a.next2D();
    EXPECT_EQ(a.next1D(), forth[2]);
}

TEST(SobolStream, PowerOfTwoPrefixesAreStratifiedInEveryElementaryInterval) {
    // (0, 2)-net in base 2: each of the 2^m first points lies alone in its cell of every 2^a x 2^(m-a) grid.
    for (const uint64_t key : {1ull, 77ull, 12345678901ull})
        for (const int block : {0, 1, 4})
            for (int m = 0; m <= 10; ++m) {
                const uint32_t n = 1u << m;
                std::vector<Vec2f> points(n), second(n);
                for (uint32_t i = 0; i < n; ++i) {
                    SobolStream s(key, i);
                    s.seek(block);
                    points[i] = s.next2D();
                    second[i] = s.next2D();
                    ASSERT_TRUE(points[i].x >= 0 && points[i].x < 1 && points[i].y >= 0 && points[i].y < 1);
                }
                for (const std::vector<Vec2f>* set : {&points, &second})
                    for (int a = 0; a <= m; ++a) {
                        std::set<std::pair<int, int>> cells;
                        for (const Vec2f& p : *set)
                            cells.emplace(static_cast<int>(std::ldexp(p.x, a)),
                                          static_cast<int>(std::ldexp(p.y, m - a)));
                        ASSERT_EQ(cells.size(), n)
                            << "key " << key << " block " << block << " m " << m << " a " << a;
                    }
            }
}

TEST(SobolStream, LaterAlignedBlocksOfSamplesAreStratifiedToo) {
    // Samples 2^m k ... 2^m (k + 1) - 1, as a resumed render has them.
    for (const uint32_t first : {64u, 960u, 1u << 20, 0xffffffc0u}) {
        std::set<std::pair<int, int>> cells;
        std::set<int> intervals;
        for (uint32_t i = 0; i < 64; ++i) {
            SobolStream s(5, first + i);
            s.seek(2);
            intervals.insert(static_cast<int>(s.next1D() * 64));
            s.next1D();
            const Vec2f p = s.next2D();
            cells.emplace(static_cast<int>(p.x * 8), static_cast<int>(p.y * 8));
        }
        EXPECT_EQ(cells.size(), 64u) << first;
        EXPECT_EQ(intervals.size(), 64u) << first;
    }
}

TEST(SobolStream, SingleCoordinatesAreStratified) {
    for (int m = 0; m <= 12; ++m)
        for (const int block : {0, 1, 9}) {
            std::set<int> intervals;
            for (uint32_t i = 0; i < (1u << m); ++i) {
                SobolStream s(hashKey(3, m), i);
                s.seek(block);
                intervals.insert(static_cast<int>(std::ldexp(s.next1D(), m)));
            }
            ASSERT_EQ(intervals.size(), size_t(1) << m);
        }
}

TEST(SobolStream, APointOverManyKeysIsUniform) {
    // Owen scrambling makes each point uniform, so that the estimates are unbiased.
    constexpr int kBins = 32, kKeys = 150000;
    for (const uint32_t index : {0u, 1u, 6u}) {
        std::vector<double> counts(kBins * kBins);
        for (int key = 0; key < kKeys; ++key) {
            SobolStream s(hashKey(17, key), index);
            s.seek(1);
            const Vec2f p = s.next2D();
            counts[static_cast<int>(p.y * kBins) * kBins + static_cast<int>(p.x * kBins)] += 1;
        }
        EXPECT_GT(chiSquarePValue(counts), kLevel) << index;
    }
}

/// Correlation of two equally long series as a standard normal deviate (both uniform and independent under
/// test).
double correlation(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - 0.5) * (b[i] - 0.5);
    return sum * 12 / std::sqrt(double(a.size()));
}

TEST(Streams, DifferentKeysAndCoordinatesAreUncorrelated) {
    // Pearson correlations of first and centerd second powers; 500 comparisons at 1e-6 each: 5e-4 in all.
    constexpr int kKeys = 20000;
    const auto value = [](bool sobol, uint64_t key, int coordinate) {
        SobolStream s(key, 3);
        IndependentStream r(key);
        SampleStream& stream = sobol ? static_cast<SampleStream&>(s) : r;
        stream.seek(1 + coordinate / 4);
        float v = 0;
        for (int i = 0; i <= coordinate % 4; ++i) v = stream.next1D();
        return v;
    };
    for (const bool sobol : {false, true})
        for (int coordinate = 0; coordinate < 8; ++coordinate) {
            std::vector<float> here(kKeys), neighbor(kKeys), far(kKeys), next(kKeys);
            for (int k = 0; k < kKeys; ++k) {
                here[k] = value(sobol, hashKey(1, k), coordinate);
                neighbor[k] = value(sobol, hashKey(1, k + 1), coordinate);
                far[k] = value(sobol, hashKey(1, k + 4096), coordinate);
                next[k] = value(sobol, hashKey(1, k), coordinate + 1);
            }
            EXPECT_GT(normalPValue(correlation(here, neighbor)), kLevel) << coordinate;
            EXPECT_GT(normalPValue(correlation(here, far)), kLevel) << coordinate;
            EXPECT_GT(normalPValue(correlation(here, next)), kLevel) << coordinate;
        }
}

TEST(SobolStream, PatternsOfDifferentPixelsAreShuffledAgainstEachOther) {
    // The same sample indices of two keys, over 64 indices and 500 pairs of keys: uncorrelated on average.
    double sum = 0;
    constexpr int kPairs = 500, kSamples = 64;
    for (int pair = 0; pair < kPairs; ++pair) {
        std::vector<float> a(kSamples), b(kSamples);
        for (uint32_t i = 0; i < kSamples; ++i) {
            SobolStream s(hashKey(8, pair, 0), i), t(hashKey(8, pair, 1), i);
            s.seek(1), t.seek(1);
            a[i] = s.next1D(), b[i] = t.next1D();
        }
        sum += correlation(a, b);
    }
    EXPECT_GT(normalPValue(sum / std::sqrt(double(kPairs))), kLevel);
}

TEST(SobolStream, IntegratesSmoothFunctionsBetterThanIndependentNumbers) {
    // Mean squared error of the mean of x y over 64 samples; random numbers: var / n = 7 / 144 / 64.
    double squared = 0;
    constexpr int kTrials = 300, kSamples = 64;
    for (int trial = 0; trial < kTrials; ++trial) {
        double sum = 0;
        for (uint32_t i = 0; i < kSamples; ++i) {
            SobolStream s(hashKey(30, trial), i);
            s.seek(3);
            const Vec2f p = s.next2D();
            sum += double(p.x) * p.y;
        }
        squared += sqr(sum / kSamples - 0.25) / kTrials;
    }
    EXPECT_LT(squared, 0.02 * 7 / 144.0 / kSamples);
}

}  // namespace
}  // namespace metrolux::core
