/// Lanes of replicas on a toy integrand: their weighted sum is the integral, with the normalizations that
/// they estimate themselves.

#include "markov/replica_lanes.h"

#include "support/block_statistics.h"

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

namespace metrolux::core {
namespace {

/// F = 1 + 30 y for x from `from` to `from` + visibleShare (around the end of the interval), else invisible.
struct ToyValue {
    double x = 0, size = 0;
    bool visible() const { return size > 0; }
};

struct ToyModel {
    double visibleShare;
    std::vector<double> sums;  ///< of each lane: of weight * (size + h) ...
    double invisible = 0;      ///< ... h of what is invisible
    double from = 0;

    void startUniform(PrimarySample&, CounterRng&, size_t, size_t) const {}
    using Evaluations = std::span<const Evaluation<ToyValue>>;
    void evaluateUniform(Evaluations evaluations) const { evaluate(evaluations); }
    void evaluate(Evaluations evaluations) const {
        for (const auto& [stream, value] : evaluations) evaluate(*stream, *value);
    }
    void evaluate(SampleStream& u, ToyValue& v) const {
        u.seek(0);
        const Vec2f p = u.next2D();
        v.x = p.x;
        const double x = p.x - from;
        v.size = x - std::floor(x) < visibleShare ? 1 + 30 * p.y : 0;
    }
    void pay(size_t lane, const ToyValue& v, double weight) {
        sums[lane] += weight * (v.visible() ? v.size : invisible);
    }
};

struct Case {
    bool uniform, visibility, contribution;
    double visibleShare, invisible;
    std::array<double, 3> split{1, 1, 1};
    NormalizationMethod normalization = NormalizationMethod::Pooled;
    bool pooledTheta = false;
    bool measuredSplit = false;
    int iterations = 40;
    bool moves = false;  ///< what is visible is elsewhere in each iteration, as with new eye vertices
};

/// Mean over iterations of one seed.
double estimate(const Case& c, uint64_t seed) {
    constexpr size_t kSamples = 600;
    ReplicaSettings s;
    s.seed = seed;
    s.kernel = MutationKernel::Kind::Adaptive;
    s.inefficiency = 3;
    s.lanes = 8;
    s.uniform = c.uniform;
    s.visibility = c.visibility;
    s.contribution = c.contribution;
    s.split = c.split;
    s.normalization = c.normalization;
    s.pooledTheta = c.pooledTheta;
    s.measuredSplit = c.measuredSplit;
    ReplicaLanes<ToyValue> lanes(s);
    ToyModel model{c.visibleShare, std::vector<double>(8, 0.0), c.invisible};
    for (int i = 0; i < c.iterations; ++i) {
        if (c.moves) model.from = CounterRng(hashKey(seed, i)).nextDouble();
        lanes.normalization().update(1);
        ReplicaMixture mix = lanes.mixture(kSamples, i > 0);
        if (mix.uniform > 0 && c.invisible > 0) mix.invisibleWeight = 1 / mix.uniform;
        lanes.run(model, mix, uint32_t(i), 0);
        lanes.endIteration(1);
    }
    double sum = 0;
    for (const double x : model.sums) sum += x;
    return sum / c.iterations;
}

TEST(ReplicaLanes, WeightedSumsAreTheIntegral) {
    constexpr int kSeeds = 32;
    constexpr double kRate = 1e-3;  // that any of the cases fails by chance
    const std::vector<Case> cases{
        {true, false, false, 0.3, 0},
        {true, true, false, 0.3, 0},
        {true, false, true, 0.3, 0},
        {true, true, true, 0.3, 0},
        {true, true, true, 0.05, 0},
        {true, true, false, 0.3, 2},
        {true, true, true, 1, 0},
        {true, true, false, 0.05, 5},
        {true, true, true, 0.3, 0, {4, 1, 1}},
        {true, true, true, 0.3, 0, {1, 2, 5}},
        {true, true, false, 0.3, 2, {1, 3, 1}},
        {true, true, true, 0.3, 0, {1, 1, 1}, NormalizationMethod::Bennett},
        {true, true, true, 0.3, 0, {1, 1, 1}, NormalizationMethod::Pooled, true},
        {true, true, true, 0.3, 0, {1, 1, 1}, NormalizationMethod::Pooled, false, true},
        {true, true, false, 0.3, 2, {1, 1, 1}, NormalizationMethod::Pooled, false, true},
        // Each replica alone, and the chains.
        {false, true, false, 0.3, 0},
        {false, false, true, 0.3, 0},
        {false, true, true, 0.3, 0},
        // Fewer than one visible uniform sample an iteration, and never where one was before.
        {true, true, false, 0.004, 0, {1, 1, 1}, NormalizationMethod::Pooled, false, false, 800, true},
        {true, true, true, 0.004, 0, {1, 1, 1}, NormalizationMethod::Pooled, false, false, 800, true},
    };
    for (size_t k = 0; k < cases.size(); ++k) {
        const Case& c = cases[k];
        std::vector<double> values;
        double mean = 0;
        for (int seed = 0; seed < kSeeds; ++seed) {
            values.push_back(estimate(c, hashKey(k, seed)));
            mean += values.back() / kSeeds;
        }
        double scatter = 0;
        for (const double v : values) scatter += (v - mean) * (v - mean);
        const double error = std::sqrt(scatter / (kSeeds - 1) / kSeeds);
        const double expected = c.visibleShare * 16 + (1 - c.visibleShare) * c.invisible;
        const double critical = boost::math::quantile(boost::math::complement(
            boost::math::students_t(kSeeds - 1), test::sidak(kRate, double(cases.size())) / 2));
        EXPECT_LE(std::abs(mean - expected), critical * error)
            << "case " << k << ": " << mean << " +- " << error << ", expected " << expected;
        EXPECT_LT(critical * error, 0.05 * expected) << "case " << k << ": too noisy to decide";
    }
}

TEST(ReplicaLanes, DoNotDependOnWhichAreRunTogether) {
    // More threads make smaller groups.
    const auto run = [](int threads, size_t samples) {
        ReplicaSettings s;
        s.seed = 5;
        s.inefficiency = 3;
        s.lanes = 24;
        s.measuredSplit = true;
        ReplicaLanes<ToyValue> lanes(s);
        ToyModel model{0.3, std::vector<double>(24, 0.0)};
        tbb::task_arena arena(threads);
        arena.execute([&] {
            for (uint32_t i = 0; i < 6; ++i) {
                lanes.normalization().update(1);
                ReplicaMixture mix = lanes.mixture(samples, i > 0);
                lanes.run(model, mix, i, 0);
                lanes.endIteration(1);
            }
        });
        model.sums.push_back(double(lanes.counts().swapsMade));
        return model.sums;
    };
    // From a pool of visible samples, some of which are taken later, and from a few, or none.
    for (const size_t samples : {size_t{20000}, size_t{30}}) {
        const std::vector<double> one = run(1, samples);
        EXPECT_GT(one.back(), 0);
        EXPECT_EQ(one, run(4, samples));
        EXPECT_EQ(one, run(16, samples));
    }
}

TEST(ReplicaLanes, MixtureCountsWhatTheLanesTake) {
    ReplicaSettings s;
    s.lanes = 7;
    s.contribution = false;
    const ReplicaLanes<ToyValue> lanes(s);
    const ReplicaMixture chains = lanes.mixture(100), uniform = lanes.mixture(100, false);
    EXPECT_EQ(chains.uniform, 56);  // 50, rounded up to a multiple of 7
    EXPECT_EQ(chains.visibility, 56);
    EXPECT_EQ(chains.contribution, 0);
    EXPECT_EQ(uniform.uniform, 105);
    EXPECT_EQ(uniform.samples(), 105);

    s.contribution = true;
    s.split = {1, 2, 4};
    const ReplicaMixture uneven = ReplicaLanes<ToyValue>(s).mixture(700);
    EXPECT_EQ(uneven.uniform, 105);  // 100, rounded up
    EXPECT_EQ(uneven.visibility, 203);
    EXPECT_EQ(uneven.contribution, 406);  // 400
}

TEST(ReplicaLanes, TakesAsManySamplesAsTheMixtureSays) {
    struct CountingModel : ToyModel {
        explicit CountingModel(size_t lanes) : ToyModel{1, std::vector<double>(lanes, 0.0)} {}
        std::array<std::vector<size_t>, 3> uniform;  ///< numbers of the uniform samples of each lane
        void startUniform(PrimarySample&, CounterRng&, size_t lane, size_t sample) {
            uniform[lane].push_back(sample);
        }
    };
    ReplicaSettings s;
    s.lanes = 3;
    s.split = {2, 5, 3};
    ReplicaLanes<ToyValue> lanes(s);
    CountingModel model(3);
    lanes.normalization().update(1);
    ReplicaMixture mix = lanes.mixture(3000);
    lanes.run(model, mix, 0, 0);
    for (const std::vector<size_t>& samples : model.uniform) {
        ASSERT_EQ(samples.size(), size_t(mix.uniform) / 3);
        for (size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(samples[i], i);
    }
    const ReplicaCounts c = lanes.counts();
    // A visible uniform sample that falls to a step of the visibility replica takes the place of its
    // mutation.
    EXPECT_EQ(c.visibility.tried + c.uniformSwaps, uint64_t(mix.visibility));
    EXPECT_EQ(c.contribution.tried, uint64_t(mix.contribution));
}

}  // namespace
}  // namespace metrolux::core
