/// "A chain of each kind resumed from its state continues bit for bit" (issue 4, item 2;
/// docs/explain/algorithm.md section 5).

#include "base/state_archive.h"
#include "markov/metropolis.h"
#include "markov/replica_lanes.h"
#include "support/chain_state.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace metrolux::core {
namespace {

using Kind = MutationKernel::Kind;

/// A slope that is black on one side.
struct Value {
    std::vector<float> point;
    double size = 0;
    bool visible() const { return size > 0; }
    template <class Archive>
    void serialize(Archive& archive) {
        archive(point, size);
    }
};

void evaluate(SampleStream& u, Value& v) {
    u.seek(0);
    const Vec2f p = u.next2D();
    // Some samples ask for more coordinates than others.
    v.point = {p.x, p.y};
    if (p.x > 0.5f) v.point.push_back(u.next1D());
    v.size = p.x < 0.3f ? 0 : 0.1 + p.x * p.y;
}

struct SizeTarget {
    double operator()(const Value& v) const { return v.size; }
};

/// What a run has done, in order: two runs are the same if these are.
using Trace = std::vector<double>;

void append(Trace& trace, const Value& v, double weight) {
    trace.insert(trace.end(), v.point.begin(), v.point.end());
    trace.push_back(v.size);
    trace.push_back(weight);
}

/// Runs `first` steps of an object, saves it and goes on with it and with a copy from the saved state; a new
/// object stands for a computation that lost its state.
template <class Make, class Run>
void expectResumes(Make&& make, Run&& run) {
    auto original = make();
    Trace before;
    run(*original, 0, before);
    const std::string state = saveState(*original);
    Trace expected, resumed, lost;
    run(*original, 1, expected);
    auto copy = make();
    loadState(state, *copy);
    EXPECT_EQ(saveState(*copy), state);
    run(*copy, 1, resumed);
    EXPECT_EQ(expected, resumed);
    EXPECT_EQ(saveState(*original), saveState(*copy));
    run(*make(), 1, lost);
    EXPECT_NE(expected, lost) << "the test would not notice a state that is not restored";
    EXPECT_GT(expected.size(), 50u);

    for (const size_t size : {size_t{0}, state.size() / 2, state.size() - 1})
        EXPECT_THROW(loadState(std::string_view(state).substr(0, size), *make()), Error) << size;
    EXPECT_THROW(loadState(state + "x", *make()), Error);
}

class Resume : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kernels, Resume, testing::Values(Kind::Adaptive, Kind::Kelemen),
                         [](const testing::TestParamInfo<Kind>& kernel) {
                             return kernel.param == Kind::Adaptive ? "adaptive" : "kelemen";
                         });

/// A chain with the random numbers that its owner draws for it.
struct DrivenChain {
    explicit DrivenChain(Kind kind) : chain(SizeTarget{}, kind) {
        uniformSample(evaluate, chain.state(), 99);
    }
    MarkovChain<Value, SizeTarget> chain;
    CounterRng rng{7};
    template <class Archive>
    void serialize(Archive& archive) {
        archive(chain, rng);
    }
};

TEST_P(Resume, MarkovChain) {
    expectResumes([] { return std::make_unique<DrivenChain>(GetParam()); },
                  [](DrivenChain& d, int, Trace& trace) {
                      test::evaluateState(d.chain, evaluate, d.rng);
                      MarkovState<Value> proposal;
                      for (int i = 0; i < 300; ++i) {
                          const bool large = i % 7 == 0;
                          const double a = large
                                               ? d.chain.proposeUniform(evaluate, proposal, d.rng.nextBits())
                                               : d.chain.propose(evaluate, proposal, d.rng);
                          d.chain.decide(a, proposal, d.rng, !large);
                          append(trace, d.chain.state().value, d.chain.kernel().theta());
                      }
                  });
}

/// The model of the lanes' test: pays into a trace of each lane.
struct TraceModel {
    std::vector<Trace> lanes;
    void startUniform(PrimarySample&, CounterRng&, size_t, size_t) const {}
    using Evaluations = std::span<const Evaluation<Value>>;
    void evaluateUniform(Evaluations evaluations) const { evaluate(evaluations); }
    void evaluate(Evaluations evaluations) const {
        for (const auto& [stream, value] : evaluations) metrolux::core::evaluate(*stream, *value);
    }
    void pay(size_t lane, const Value& v, double weight) { append(lanes[lane], v, weight); }
};

TEST_P(Resume, ReplicaLanes) {
    // Many samples start chains from a pool, few go on from the states of the iteration before.
    for (const size_t samples : {size_t{3}, size_t{600}}) {
        ReplicaSettings settings;
        settings.seed = 3;
        settings.kernel = GetParam();
        settings.lanes = samples == 3 ? 1 : 4;
        settings.inefficiency = 3;
        settings.measuredSplit = samples == 600;
        expectResumes([&] { return std::make_unique<ReplicaLanes<Value>>(settings); },
                      [&](ReplicaLanes<Value>& lanes, int part, Trace& trace) {
                          for (int i = 0; i < 30; ++i) {
                              const double squaredRadius = 1.0 / (1 + 30 * part + i);
                              lanes.normalization().update(squaredRadius);
                              ReplicaMixture mix = lanes.mixture(samples, part > 0 || i > 0);
                              TraceModel model{std::vector<Trace>(lanes.size())};
                              lanes.run(model, mix, static_cast<uint32_t>(30 * part + i), 0);
                              lanes.endIteration(squaredRadius);
                              for (const Trace& t : model.lanes)
                                  trace.insert(trace.end(), t.begin(), t.end());
                          }
                      });
    }
}

TEST_P(Resume, MetropolisLanes) {
    MetropolisOptions options;
    options.key = 5;
    options.kind = GetParam();
    options.lanes = 3;
    options.steeringSamples = 16;
    options.poolSamples = 32;
    const auto make = [&] { return std::make_unique<MetropolisSampler<Value>>(options); };
    for (const bool anew : {false, true})
        expectResumes(make, [&](MetropolisSampler<Value>& sampler, int, Trace& trace) {
            const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
            const auto pay = [&](const Value& v, double weight) { append(trace, v, weight); };
            for (int i = 0; i < 4; ++i) {
                if (anew)
                    sampler.integrateAnew(20, 60, evaluate, pay);
                else
                    sampler.integrate(60, evaluate, pay);
            }
        });
}

TEST(Resume, StatesOfAnotherShapeAreRefused) {
    const auto lanes = [](int count) {
        ReplicaSettings settings;
        settings.lanes = count;
        return std::make_unique<ReplicaLanes<Value>>(settings);
    };
    EXPECT_THROW(loadState(saveState(*lanes(2)), *lanes(3)), Error);
    // Values that would be read outside of their tables.
    for (const float bad : {-0.5f, 1.0f, std::numeric_limits<float>::quiet_NaN()}) {
        DrivenChain chain(Kind::Adaptive);
        constexpr float kMark = 0.123456789f;
        chain.chain.state().u = {0.5f, kMark};
        std::string state = saveState(chain);
        const size_t at = state.find(std::string(reinterpret_cast<const char*>(&kMark), sizeof(kMark)));
        ASSERT_NE(at, std::string::npos);
        state.replace(at, sizeof(bad), reinterpret_cast<const char*>(&bad), sizeof(bad));
        DrivenChain other(Kind::Adaptive);
        EXPECT_THROW(loadState(state, other), Error) << bad;
    }
}

}  // namespace
}  // namespace metrolux::core
