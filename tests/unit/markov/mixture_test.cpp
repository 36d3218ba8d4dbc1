/// The estimator of mcmc_vcm on a toy: three replicas, exchange, expected-value weights and the mixture
/// weight
///     W(u) = 1 / (n_U + n_V V(u) / (g b_V) + n_F F(u) / (g b_F))
/// (W/g for steps of chains) with the exact b_V and b_F is unbiased in each pixel. Lanes are independent: a
/// t-test over lanes is exact. It is the order of steps of McmcVcmIntegrator::runLane, on values that can be
/// integrated by hand.

#include "markov/chain.h"
#include "markov/replica_mixture.h"
#include "support/chain_state.h"
#include "support/goodness_of_fit.h"

#include <boost/math/distributions/students_t.hpp>
#include <gtest/gtest.h>

#include <array>

namespace metrolux::core {
namespace {

using Kind = MutationKernel::Kind;

constexpr int kPixels = 4;
using Pixels = std::array<double, kPixels>;

struct Value {
    Pixels pixels{};
    double size = 0;
    bool visible() const { return size > 0; }
};
struct VisibilityTarget {
    double operator()(const Value& v) const { return v.visible() ? 1 : 0; }
};
struct ContributionTarget {
    double operator()(const Value& v) const { return v.size; }
};

/// Visible in a strip and in a small spot that is a thousand times as bright; four pixels by the second
/// coordinate.
Value evaluateAt(float x, float y) {
    Value v;
    const bool strip = x > 0.55f && x<0.75f, spot = x> 0.90f && x < 0.91f && y < 0.3f;
    if (!strip && !spot) return v;
    const int pixel = std::min(static_cast<int>(y * kPixels), kPixels - 1);
    v.pixels[pixel] = spot ? 200.0 : 0.2 * (1 + x);
    v.pixels[(pixel + 1) % kPixels] += 0.1;
    for (const double p : v.pixels) v.size += p;
    return v;
}

void evaluate(SampleStream& stream, Value& value) {
    stream.seek(0);
    const Vec2f u = stream.next2D();
    value = evaluateAt(u.x, u.y);
}

struct Reference {
    Pixels pixels{};
    double bVisibility = 0, bContribution = 0;
};
Reference reference() {
    Reference r;
    constexpr int n = 4000;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const Value v =
                evaluateAt((static_cast<float>(i) + 0.5f) / n, (static_cast<float>(j) + 0.5f) / n);
            for (int k = 0; k < kPixels; ++k) r.pixels[k] += v.pixels[k] / (double(n) * n);
            r.bVisibility += (v.visible() ? 1.0 : 0.0) / (double(n) * n);
            r.bContribution += v.size / (double(n) * n);
        }
    return r;
}

class Lane {
  public:
    Lane(uint64_t seed, Kind kind, const Reference& b, double inefficiency, double steps)
        : rng_(seed), v_({}, kind), f_({}, kind), mix_{steps,         steps,           steps,
                                                       b.bVisibility, b.bContribution, inefficiency} {
        const double largest = 250;
        do v_.state().u = {rng_.next1D(), rng_.next1D()};
        while (!evaluateAt(v_.state().u[0], v_.state().u[1]).visible());
        do f_.state().u = {rng_.next1D(), rng_.next1D()};
        while (rng_.nextDouble() * largest >= evaluateAt(f_.state().u[0], f_.state().u[1]).size);
        test::evaluateState(v_, evaluate, rng_);
        test::evaluateState(f_, evaluate, rng_);
    }

    void run(int steps) {
        for (int i = 0; i < steps; ++i) step();
        payOut(v_.state());
        payOut(f_.state());
    }
    void forget() { image_ = {}; }
    const Pixels& image() const { return image_; }
    double largestWeight() const { return largestWeight_; }

  private:
    using State = MarkovState<Value>;

    void payOut(State& s) {
        for (int k = 0; k < kPixels; ++k) image_[k] += s.weight * s.value.pixels[k];
        s.weight = 0;
    }
    void step() {
        bool fresh = false;
        State u;
        PrimarySampleStream stream(u.u, rng_);
        evaluate(stream, u.value);
        if (u.value.visible()) {
            u.weight = mix_.uniformWeight(u.value.size);
            largestWeight_ = std::max(largestWeight_, u.weight);
            payOut(v_.state());
            std::swap(u, v_.state());
            fresh = true;
        }
        if (!fresh) {
            const double a = v_.propose(evaluate, proposal_, rng_);
            if (v_.decide(a, proposal_, rng_)) payOut(proposal_);
        }
        v_.state().weight += mix_.visibilityWeight(v_.state().value.size);

        const double a = f_.propose(evaluate, proposal_, rng_);
        proposal_.weight = a * mix_.contributionWeight(proposal_.value.size);
        f_.state().weight += (1 - a) * mix_.contributionWeight(f_.state().value.size);
        f_.decide(a, proposal_, rng_);
        payOut(proposal_);
        exchangeReplicas(v_, f_, rng_);
    }

    CounterRng rng_;
    MarkovChain<Value, VisibilityTarget> v_;
    MarkovChain<Value, ContributionTarget> f_;
    ReplicaMixture mix_;
    State proposal_;
    Pixels image_{};
    double largestWeight_ = 0;
};

/// Smallest p-value over pixels that the lanes' mean is the reference.
double pValue(Kind kind, const Reference& truth, const Reference& b, double inefficiency, int burnIn,
              uint64_t seed) {
    constexpr int kLanes = 1500, kSteps = 200;
    Pixels sum{}, squares{};
    for (int lane = 0; lane < kLanes; ++lane) {
        Lane l(hashKey(seed, lane), kind, b, inefficiency, kSteps);
        l.run(burnIn);
        l.forget();
        l.run(kSteps);
        EXPECT_LE(l.largestWeight(), 1.0 / kSteps);  // the uniform replica bounds every weight
        for (int k = 0; k < kPixels; ++k) {
            sum[k] += l.image()[k];
            squares[k] += sqr(l.image()[k]);
        }
    }
    double smallest = 1;
    for (int k = 0; k < kPixels; ++k) {
        const double mean = sum[k] / kLanes,
                     variance = (squares[k] - kLanes * mean * mean) / (kLanes - 1.0) / kLanes;
        const double t = (mean - truth.pixels[k]) / std::sqrt(variance);
        smallest = std::min(smallest, 2 * boost::math::cdf(boost::math::complement(
                                              boost::math::students_t(kLanes - 1), std::abs(t))));
    }
    return smallest;
}

TEST(ReplicaMixture, IsUnbiasedWithTheExactNormalizations) {
    const Reference truth = reference();
    for (const uint64_t seed : {1, 2, 3})
        for (const double inefficiency : {1.0, 4.0}) {
            EXPECT_GT(pValue(Kind::Kelemen, truth, truth, inefficiency, 0, seed), test::kLevel)
                << inefficiency;
            EXPECT_GT(pValue(Kind::Adaptive, truth, truth, inefficiency, 500, seed), test::kLevel)
                << inefficiency;
        }
}

TEST(ReplicaMixture, AWrongNormalizationWouldBeSeen) {
    const Reference truth = reference();
    Reference wrong = truth;
    wrong.bContribution *= 0.9;
    EXPECT_LT(pValue(Kind::Kelemen, truth, wrong, 4, 0, 4), test::kLevel);
    wrong = truth;
    wrong.bVisibility *= 0.9;
    EXPECT_LT(pValue(Kind::Kelemen, truth, wrong, 4, 0, 5), test::kLevel);
}

}  // namespace
}  // namespace metrolux::core
