#include "integrators/light_subpath_set.h"

#include "base/parallel.h"
#include "integrators/path_pair.h"
#include "markov/replica_schedule.h"
#include "sampling/streams.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

/// Visible samples that b_V rests on before chains are used.
constexpr double kVisibleSamplesToStart = 64;

void append(std::vector<Vertex>& to, const std::vector<Vertex>& from, double weight) {
    for (const Vertex& v : from) {
        to.push_back(v);
        to.back().throughput *= static_cast<float>(weight);
    }
}

}  // namespace

VisibilityDrivenSet::VisibilityDrivenSet(uint64_t seed, const ChainParameters& chains, double inefficiency,
                                         size_t samples)
    : rng_(hashKey(seed, StreamPurpose::Seeding, 'L')), inefficiency_(inefficiency) {
    const auto lanes = static_cast<size_t>(laneCount(chains, samples));
    for (size_t i = 0; i < lanes; ++i)
        lanes_.emplace_back(hashKey(seed, StreamPurpose::Chain, 'L', i), chains.kernel);
}

void VisibilityDrivenSet::begin(size_t samples, double radius) {
    squaredRadius_ = radius * radius;
    normalization_.update(squaredRadius_);
    chainsRun_ = normalization_.visibleSamples() >= kVisibleSamplesToStart;
    mix_ = {};
    mix_.inefficiency = inefficiency_;
    mix_.bVisibility = normalization_.visibility();
    mix_.uniform = double(chainsRun_ ? std::max<size_t>(1, samples / 2) : samples);
    mix_.visibility = chainsRun_ ? mix_.uniform : 0;
}

size_t VisibilityDrivenSet::stepsOf(size_t lane) const {
    return stepsOfLane(static_cast<size_t>(mix_.uniform), lanes_.size(), lane);
}

void VisibilityDrivenSet::evaluate(const LightSubpathTracing& tracing, const VertexGrid& eyeGrid,
                                   SampleStream& u, Value& value) {
    value.vertices.clear();
    tracing.trace(u, value.vertices);
    value.size = std::any_of(value.vertices.begin(), value.vertices.end(),
                             [&](const Vertex& v) { return eyeGrid.anyWithin(v.si.p); });
}

void VisibilityDrivenSet::Lane::pay(State& state) {
    state.payOut([&](const Value& value, double weight) { append(result, value.vertices, weight); });
}

std::vector<Vertex> VisibilityDrivenSet::make(const LightSubpathTracing& tracing, const VertexGrid& eyeGrid) {
    parallelFor(lanes_.size(), [&](size_t i) { takeUniform(lanes_[i], stepsOf(i), tracing, eyeGrid); });
    if (chainsRun_) startChains();
    parallelFor(lanes_.size(), [&](size_t i) { runLane(lanes_[i], stepsOf(i), tracing, eyeGrid); });
    std::vector<Vertex> all;
    for (size_t i = 0; i < lanes_.size(); ++i) {
        Lane& lane = lanes_[i];
        all.insert(all.end(), lane.result.begin(), lane.result.end());
        normalization_.add(static_cast<int>(i), lane.samples);
        lane.samples.clear();
        lane.result.clear();
        lane.uniform.clear();
    }
    normalization_.endIteration(squaredRadius_);
    if (tracing.photons) tracing.photons->endIteration(mix_.uniform);
    return all;
}

void VisibilityDrivenSet::takeUniform(Lane& lane, size_t steps, const LightSubpathTracing& tracing,
                                      const VertexGrid& eyeGrid) {
    const auto evaluateHere = [&](SampleStream& u, Value& v) { evaluate(tracing, eyeGrid, u, v); };
    for (size_t step = 0; step < steps; ++step) {
        State state = lane.uniform.spare();
        uniformSample(evaluateHere, state, lane.rng.nextBits());
        tracing.count(state.value.vertices);
        lane.samples.addUniform(state.value.size);
        if (!state.value.visible()) {
            state.weight = 1 / mix_.uniform;
            lane.pay(state);
        }
        lane.uniform.add(std::move(state));
    }
}

/// Chains start from visible uniform samples of this iteration, with start-up weights (ReplicaMixture).
void VisibilityDrivenSet::startChains() {
    ReplicaPool<Value> pool;
    for (const Lane& lane : lanes_) pool.add(lane.uniform);
    mix_.visibilityScale = pool.visible() / (mix_.uniform * mix_.bVisibility);
    const double offset = rng_.nextDouble();
    if (pool.empty()) {  // scale 0: the chains wait for light
        for (Lane& lane : lanes_) lane.chain.state() = {};
        return;
    }
    const auto starts = pool.draw(lanes_.size(), offset);
    for (size_t i = 0; i < lanes_.size(); ++i) lanes_[i].chain.state() = *starts[i];
}

void VisibilityDrivenSet::runLane(Lane& lane, size_t steps, const LightSubpathTracing& tracing,
                                  const VertexGrid& eyeGrid) {
    const auto evaluateHere = [&](SampleStream& u, Value& v) { evaluate(tracing, eyeGrid, u, v); };
    constexpr double kVisible = 1;
    State& state = lane.chain.state();
    for (size_t step = 0; step < steps; ++step) {
        if (State* fresh = lane.uniform.take()) {
            fresh->weight = mix_.uniformWeight(kVisible);
            if (!chainsRun_) {
                lane.pay(*fresh);
                continue;
            }
            // Exchange with the uniform replica is certain for a visible sample [HJ11].
            lane.pay(state);
            std::swap(state, *fresh);
        } else if (chainsRun_ && state.value.visible()) {
            const double a = lane.chain.propose(evaluateHere, lane.proposal, lane.rng);
            if (lane.chain.decide(a, lane.proposal, lane.rng)) lane.pay(lane.proposal);
        }
        if (chainsRun_ && state.value.visible()) state.weight += mix_.visibilityWeight(kVisible);
    }
    lane.pay(state);
}

nlohmann::json VisibilityDrivenSet::statistics() const {
    uint64_t tried = 0, accepted = 0;
    for (const Lane& lane : lanes_) {
        tried += lane.chain.kernel().tried();
        accepted += lane.chain.kernel().accepted();
    }
    return {{"lanes", lanes_.size()},
            {"b_v", normalization_.visibility()},
            {"tried", tried},
            {"acceptance", tried ? double(accepted) / double(tried) : 0.0}};
}

ChainStateSet::ChainStateSet(uint64_t seed, double cell, size_t lanes)
    : seed_(seed), visited_(lanes), chainMade_(cell), uniform_(cell) {}

size_t ChainStateSet::steps() const {
    size_t sum = 0;
    for (const auto& lane : visited_)
        for (const Visited& v : lane) sum += v.steps;
    return sum;
}

std::vector<std::vector<Vertex>> ChainStateSet::traceStates(const LightSubpathTracing& tracing) {
    std::vector<std::vector<Vertex>> result(visited_.size());
    parallelFor(visited_.size(), [&](size_t i) {
        CounterRng rng(hashKey(seed_, StreamPurpose::Replacement, i));
        std::vector<Vertex> vertices;
        for (Visited& visited : visited_[i]) {
            PrimarySampleStream u(visited.u, rng);
            InterleavedStream light(u, layout::kLightStream, layout::kStreams);
            vertices.clear();
            tracing.trace(light, vertices);
            for (const Vertex& v : vertices) chainMade_.count(v.si.p, visited.steps);
            append(result[i], vertices, visited.steps);
        }
    });
    return result;
}

std::vector<std::vector<Vertex>> ChainStateSet::traceUniform(const LightSubpathTracing& tracing, size_t count,
                                                             uint32_t pass, size_t first) {
    constexpr size_t kChunk = 256;
    std::vector<std::vector<Vertex>> result((count + kChunk - 1) / kChunk);
    parallelFor(result.size(), [&](size_t chunk) {
        for (size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) {
            IndependentStream u(lightSubpathKey(seed_, pass, first + i));
            tracing.trace(u, result[chunk]);
        }
        for (const Vertex& v : result[chunk]) uniform_.count(v.si.p);
        tracing.count(result[chunk]);
    });
    return result;
}

std::vector<Vertex> ChainStateSet::make(const LightSubpathTracing& tracing, size_t uniform, uint32_t pass,
                                        size_t first) {
    const double nU = double(uniform), nA = double(steps());
    const auto fromStates = traceStates(tracing);
    const auto fromUniform = traceUniform(tracing, uniform, pass, first);
    if (nA > 0) chainMade_.endIteration(nA);
    uniform_.endIteration(nU);
    if (tracing.photons) tracing.photons->endIteration(nU);
    std::vector<Vertex> all;
    for (const auto* parts : {&fromStates, &fromUniform})
        for (const std::vector<Vertex>& part : *parts)
            for (const Vertex& v : part) {
                const double known = uniform_.at(v.si.p);
                if (!(known > 0)) continue;  // no estimate of the density: left out, a part of the bias
                const double rho = nA > 0 ? chainMade_.at(v.si.p) / known : 0;
                all.push_back(v);
                all.back().throughput *= static_cast<float>(1 / (nU + nA * rho));
            }
    for (auto& lane : visited_) lane.clear();
    return all;
}

}  // namespace metrolux::core
