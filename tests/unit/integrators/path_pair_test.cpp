#include "integrators/path_pair.h"

#include "sampling/streams.h"
#include "support/block_statistics.h"
#include "support/small_scenes.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace metrolux::core {
namespace {

using test::SceneBuilder;

/// Diffuse and glass, an area light and a sky, so that all five techniques find something.
std::shared_ptr<Scene> scene(int maxDepth, const FilmWindow& window) {
    SceneBuilder b;
    b.add(test::rectangle({0, 0, 0}, {0, 1, 0}, 4, 4), test::diffuse(0.7f));
    b.add(makeSphere(Transform(), {0.6f, 1, 0}, 0.7f, false), makeDielectric({}));
    b.emit(b.add(test::rectangle({0.5f, 3, 0}, {0, -1, 0}, 0.7f, 0.5f), test::diffuse(0.3f)), Rgb(5));
    b.light(makeConstantLight({Rgb(0.2f)}));
    b.camera({0, 1.5f, 5}, {0, 1, 0}, 50, window);
    b.limits().maxDepth = maxDepth;
    return b.build();
}

FilmWindow window(int x, int y, int width, int height) {
    FilmWindow w;
    w.fullWidth = 24;
    w.fullHeight = 20;
    w.x = x;
    w.y = y;
    w.width = width;
    w.height = height;
    return w;
}

/// Notes which coordinate is read.
class Recorder final : public SampleStream {
  public:
    std::vector<int> read;
    void seek(int block) override { position_ = blockOffset(block); }
    float next1D() override {
        read.push_back(position_++);
        return 0;
    }
    Vec2f next2D() override {
        next1D();
        next1D();
        return {0, 0};
    }
    void skip(int count) override { position_ += count; }

  private:
    int position_ = 0;
};

TEST(InterleavedStream, StreamsShareNoCoordinateAndLeaveNoneOut) {
    for (const int count : {1, 2, 3}) {
        Recorder base;
        std::set<int> all;
        size_t reads = 0;
        for (int block = 0; block < 5; ++block)
            for (int index = 0; index < count; ++index) {
                InterleavedStream stream(base, index, count);
                stream.seek(block);
                const int size = block == 0 ? SampleStream::kEndpointBlock : SampleStream::kVertexBlock;
                for (int i = 0; i < size; ++i) stream.next1D();
                reads += static_cast<size_t>(size);
            }
        all.insert(base.read.begin(), base.read.end());
        EXPECT_EQ(all.size(), reads);
        EXPECT_EQ(*all.rbegin(), int(reads) - 1);
    }
}

/// Means and variances of what samples add to an image, by pixel column: 4 columns.
class Columns {
  public:
    void add(const SplatList& splats) {
        std::array<double, 4> value{};
        EXPECT_TRUE(splats.pixels.empty());
        for (const auto& s : splats.film)
            value[std::clamp(static_cast<int>(s.position.x / 6), 0, 3)] += luminance(s.value);
        for (int i = 0; i < 4; ++i) {
            sum_[i] += value[i];
            squares_[i] += value[i] * value[i];
        }
        ++n_;
    }
    double mean(int i) const { return sum_[i] / n_; }
    double varianceOfMean(int i) const { return (squares_[i] / n_ - mean(i) * mean(i)) / (n_ - 1); }

  private:
    std::array<double, 4> sum_{}, squares_{};
    double n_ = 0;
};

TEST(PathPair, SingleTechniquesAddUpToAll) {
    constexpr int kMaxDepth = 5, kSamples = 60000;
    const std::shared_ptr<Scene> s = scene(kMaxDepth, window(0, 0, 24, 20));
    const PathLimits limits = s->parts().limits;
    Film film(s->camera().window(), ReconstructionFilter(ReconstructionFilter::Kind::Box, {}));
    const Strategies strategies = Strategies::bidirectional(1, 0);
    NonFiniteCounts nonFinite;
    const PathPair pair{*s, limits, strategies, film, nonFinite};
    Columns all;
    std::map<int, Columns> one;
    SplatList splats;
    for (int i = 0; i < kSamples; ++i) {
        IndependentStream a(hashKey(1, i));
        pair.all(a, splats);
        all.add(splats);
        for (int length = 2; length <= kMaxDepth; ++length) {
            IndependentStream b(hashKey(2, length, i));
            pair.one(length, b, splats);
            EXPECT_LE(splats.film.size(), 1u);
            one[length].add(splats);
        }
    }
    for (int column = 0; column < 4; ++column) {
        double mean = 0, variance = all.varianceOfMean(column);
        for (const auto& [length, c] : one) {
            EXPECT_GT(c.mean(column), 0) << length;
            mean += c.mean(column);
            variance += c.varianceOfMean(column);
        }
        EXPECT_LT(std::abs(mean - all.mean(column)), 5 * std::sqrt(variance)) << column;
        EXPECT_LT(std::sqrt(variance), 0.03 * mean) << "too noisy to decide";
    }
}

TEST(PathPair, StaysWithinReachOfACropWindow) {
    const std::shared_ptr<Scene> s = scene(5, window(9, 15, 6, 5));
    const PathLimits limits = s->parts().limits;
    Film film(s->camera().window(), ReconstructionFilter(ReconstructionFilter::Kind::Gaussian, {}));
    const RasterRectangle reach = film.reach();
    const float margin = film.filter().radius() - 0.5f;
    EXPECT_FLOAT_EQ(reach.lower.x, 9 - margin);
    EXPECT_FLOAT_EQ(reach.upper.x, 15 + margin);
    EXPECT_FLOAT_EQ(reach.lower.y, 15 - margin);
    EXPECT_FLOAT_EQ(reach.upper.y, 20) << "the image ends here";
    const Strategies strategies = Strategies::bidirectional(1, 0);
    NonFiniteCounts nonFinite;
    const PathPair pair{*s, limits, strategies, film, nonFinite};
    SplatList splats;
    size_t found = 0;
    for (int i = 0; i < 3000; ++i) {
        IndependentStream a(hashKey(3, i)), b(hashKey(4, i));
        for (int part = 0; part < 2; ++part) {
            if (part == 0)
                pair.all(a, splats);
            else
                pair.one(3, b, splats);
            for (const auto& splat : splats.film) EXPECT_TRUE(reach.contains(splat.position));
            found += splats.film.size();
        }
    }
    EXPECT_GT(found, 2000u);
}

}  // namespace
}  // namespace metrolux::core
