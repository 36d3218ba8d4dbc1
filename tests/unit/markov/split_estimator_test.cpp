/// The measured split against the best one, which a small discrete problem has by exhaustion.

#include "markov/split_estimator.h"

#include "base/rng.h"

#include <gtest/gtest.h>

namespace metrolux::core {
namespace {

/// Contributions f on cells of equal probability under the uniform replica; some are invisible.
struct Problem {
    std::vector<double> f;

    size_t cells() const { return f.size(); }
    double visibleShare() const {
        double n = 0;
        for (const double x : f) n += x > 0;
        return n / double(cells());
    }
    double mean() const {
        double sum = 0;
        for (const double x : f) sum += x;
        return sum / double(cells());
    }
    /// Densities of the replicas at a cell, against the uniform one's.
    std::array<double, 3> densities(size_t cell) const {
        return {1, f[cell] > 0 ? 1 / visibleShare() : 0, f[cell] / mean()};
    }
    double weight(size_t cell, const std::array<double, 3>& split, double inefficiency) const {
        const auto p = densities(cell);
        return 1 / (split[0] * p[0] + (split[1] * p[1] + split[2] * p[2]) / inefficiency);
    }
    /// M of SplitEstimator.
    double noise(const std::array<double, 3>& split, double inefficiency,
                 const std::vector<double>& worth) const {
        double sum = 0;
        for (size_t i = 0; i < cells(); ++i)
            if (f[i] > 0) sum += worth[i] * weight(i, split, inefficiency) / double(cells());
        return sum;
    }
};

/// Splits in steps of 2 %, no part below a tenth.
double leastNoise(const Problem& problem, double inefficiency, const std::vector<double>& worth) {
    double least = std::numeric_limits<double>::infinity();
    for (int u = 5; u <= 40; ++u)
        for (int v = 5; u + v <= 45; ++v)
            least = std::min(least,
                             problem.noise({u / 50.0, v / 50.0, (50 - u - v) / 50.0}, inefficiency, worth));
    return least;
}

/// Feeds samples of the three replicas by their densities, as many as the split says.
std::array<double, 3> measured(const Problem& problem, double inefficiency,
                               const std::vector<double>& worth) {
    CounterRng rng(7);
    std::vector<size_t> visible, bySize;  // `bySize` repeats a cell in proportion to f
    for (size_t i = 0; i < problem.cells(); ++i) {
        if (problem.f[i] > 0) visible.push_back(i);
        bySize.insert(bySize.end(), size_t(problem.f[i]), i);
    }
    const auto any = [&](const std::vector<size_t>& of) {
        return of[size_t(rng.nextDouble() * double(of.size()))];
    };
    SplitEstimator estimator({1, 1, 1});
    for (int iteration = 0; iteration < 4 * 255; ++iteration) {  // eight batches
        const auto& split = estimator.split();
        const double total = split[0] + split[1] + split[2];
        SplitEstimator::Squares squares;
        for (size_t k = 0; k < 3; ++k)
            for (int i = 0; i < int(90 * split[k] / total); ++i) {
                const size_t cell = k == 0   ? size_t(rng.nextDouble() * double(problem.cells()))
                                    : k == 1 ? any(visible)
                                             : any(bySize);
                const double w = problem.weight(cell, split, inefficiency);
                squares.add(SplitEstimator::Replica(k), problem.f[cell] > 0 ? w * w * worth[cell] : 0);
            }
        estimator.add(squares);
        estimator.endIteration(inefficiency);
    }
    return estimator.split();
}

TEST(SplitEstimator, FindsTheSplitOfLeastNoise) {
    // Even and rare light; light with a bright spot; light that is visible nearly everywhere.
    std::vector<Problem> problems{
        {std::vector<double>(100, 0.0)}, {std::vector<double>(100, 0.0)}, {std::vector<double>(100, 3.0)}};
    for (size_t i = 0; i < 5; ++i) problems[0].f[i] = 2;
    for (size_t i = 0; i < 60; ++i) problems[1].f[i] = i == 0 ? 400 : 1;
    for (const double inefficiency : {1.0, 4.0})
        for (size_t k = 0; k < problems.size(); ++k) {
            const Problem& problem = problems[k];
            // Noise that counts absolutely, and relative to a picture that is dark where f is small.
            for (const bool relative : {false, true}) {
                std::vector<double> worth;
                for (const double f : problem.f) worth.push_back(relative ? f : f * f);
                const auto split = measured(problem, inefficiency, worth);
                EXPECT_NEAR(split[0] + split[1] + split[2], 1, 1e-9);
                const double found = problem.noise(split, inefficiency, worth),
                             even = problem.noise({1 / 3.0, 1 / 3.0, 1 / 3.0}, inefficiency, worth),
                             least = leastNoise(problem, inefficiency, worth);
                EXPECT_LT(found, 1.03 * least) << "problem " << k << ", inefficiency " << inefficiency << ": "
                                               << split[0] << "/" << split[1] << "/" << split[2];
                EXPECT_LE(found, 1.001 * even);
            }
        }
}

TEST(SplitEstimator, LeavesOutWhatIsLeftOut) {
    SplitEstimator estimator({1, 2, 0});
    SplitEstimator::Squares squares;
    squares.add(SplitEstimator::Uniform, 1);
    squares.add(SplitEstimator::Visibility, 4);
    for (int i = 0; i < 4; ++i) {
        estimator.add(squares);
        estimator.endIteration(1);
    }
    EXPECT_NEAR(estimator.split()[0], 0.2, 1e-12);  // 1 * 1 : 2 * 2
    EXPECT_NEAR(estimator.split()[1], 0.8, 1e-12);
    EXPECT_EQ(estimator.split()[2], 0);
}

TEST(SplitEstimator, WaitsForSamplesOfEveryReplica) {
    SplitEstimator estimator({1, 1, 1});
    SplitEstimator::Squares squares;
    squares.add(SplitEstimator::Uniform, 1);
    for (int i = 0; i < 40; ++i) {
        estimator.add(squares);
        estimator.endIteration(1);
    }
    EXPECT_EQ(estimator.split(), (std::array<double, 3>{1, 1, 1}));
}

}  // namespace
}  // namespace metrolux::core
