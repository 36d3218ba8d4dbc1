#include "integrators/light_set.h"

#include "base/parallel.h"
#include "sampling/streams.h"
#include "transport/path_pair.h"

#include <nlohmann/json.hpp>

namespace metrolux::core {

namespace {

/// Visible samples that b_V rests on before chains are used.
constexpr double kVisibleSamples = 64;

void append(std::vector<Vertex>& to, const std::vector<Vertex>& from, double weight) {
    for (const Vertex& v : from) {
        to.push_back(v);
        to.back().throughput *= static_cast<float>(weight);
    }
}

}  // namespace

VisibilityLightSet::VisibilityLightSet(const IntegratorOptions& options, size_t samples)
    : rng_(hashKey(options.seed, StreamPurpose::Seeding, 'L')), inefficiency_(options.chainInefficiency) {
    const auto lanes = static_cast<size_t>(laneCount(options, samples));
    const auto kind = options.kernel.value_or(MutationKernel::Kind::Kelemen);
    for (size_t i = 0; i < lanes; ++i)
        lanes_.emplace_back(hashKey(options.seed, StreamPurpose::Chain, 'L', i), kind);
}

void VisibilityLightSet::begin(size_t samples, double radius) {
    squaredRadius_ = radius * radius;
    normalization_.update(squaredRadius_);
    chainsRun_ = normalization_.visibleSamples() >= kVisibleSamples;
    mix_ = {};
    mix_.inefficiency = inefficiency_;
    mix_.bVisibility = normalization_.visibility();
    mix_.uniform = double(chainsRun_ ? std::max<size_t>(1, samples / 2) : samples);
    mix_.visibility = chainsRun_ ? mix_.uniform : 0;
}

size_t VisibilityLightSet::stepsOf(size_t lane) const {
    const size_t n = static_cast<size_t>(mix_.uniform);
    return n * (lane + 1) / lanes_.size() - n * lane / lanes_.size();
}

void VisibilityLightSet::evaluate(const LightTracing& tracing, const VertexGrid& eyeGrid, SampleStream& u,
                                  Value& value) {
    value.vertices.clear();
    tracing.trace(u, value.vertices);
    value.visible = std::any_of(value.vertices.begin(), value.vertices.end(),
                                [&](const Vertex& v) { return eyeGrid.anyWithin(v.si.p); });
}

void VisibilityLightSet::payOut(State& state, std::vector<Vertex>& result) {
    if (state.weight > 0) append(result, state.value.vertices, state.weight);
    state.weight = 0;
}

std::vector<Vertex> VisibilityLightSet::make(const LightTracing& tracing, const VertexGrid& eyeGrid) {
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
        lane.visible.clear();
    }
    normalization_.endIteration(squaredRadius_);
    if (tracing.photons) tracing.photons->endIteration(mix_.uniform);
    return all;
}

void VisibilityLightSet::takeUniform(Lane& lane, size_t steps, const LightTracing& tracing,
                                     const VertexGrid& eyeGrid) {
    const auto evaluateHere = [&](SampleStream& u, Value& v) { evaluate(tracing, eyeGrid, u, v); };
    for (size_t step = 0; step < steps; ++step) {
        State state;
        uniformSample(evaluateHere, state, lane.rng.nextBits());
        tracing.count(state.value.vertices);
        lane.samples.addUniform(state.value.visible ? 1 : 0);
        if (state.value.visible)
            lane.visible.emplace_back(step, std::move(state));
        else
            append(lane.result, state.value.vertices, 1 / mix_.uniform);
    }
}

/// Chains start from visible uniform samples of this iteration, with start-up weights (ReplicaMixture).
void VisibilityLightSet::startChains() {
    std::vector<const State*> pool;
    for (const Lane& lane : lanes_)
        for (const auto& [step, state] : lane.visible) pool.push_back(&state);
    mix_.visibilityScale = double(pool.size()) / (mix_.uniform * mix_.bVisibility);
    const double offset = rng_.nextDouble(), lanes = double(lanes_.size());
    for (size_t i = 0; i < lanes_.size(); ++i) {
        if (pool.empty()) {  // scale 0: the chains wait for light
            lanes_[i].chain.state() = {};
            continue;
        }
        const auto at = static_cast<size_t>((double(i) + offset) / lanes * double(pool.size()));
        lanes_[i].chain.state() = *pool[std::min(at, pool.size() - 1)];
    }
}

void VisibilityLightSet::runLane(Lane& lane, size_t steps, const LightTracing& tracing,
                                 const VertexGrid& eyeGrid) {
    const auto evaluateHere = [&](SampleStream& u, Value& v) { evaluate(tracing, eyeGrid, u, v); };
    constexpr double kVisible = 1;
    if (!chainsRun_) {
        for (auto& [step, state] : lane.visible)
            append(lane.result, state.value.vertices, mix_.uniformWeight(kVisible));
        return;
    }
    auto next = lane.visible.begin();
    State& state = lane.chain.state();
    for (size_t step = 0; step < steps; ++step) {
        if (next != lane.visible.end() && next->first == step) {
            // Exchange with the uniform replica is certain for a visible sample [HJ11].
            payOut(state, lane.result);
            state = std::move((next++)->second);
            state.weight = mix_.uniformWeight(kVisible);
        } else if (state.value.visible) {
            const double a = lane.chain.propose(evaluateHere, lane.proposal, lane.rng);
            if (lane.chain.decide(a, lane.proposal, lane.rng)) payOut(lane.proposal, lane.result);
        }
        if (state.value.visible) state.weight += mix_.visibilityWeight(kVisible);
    }
    payOut(state, lane.result);
}

nlohmann::json VisibilityLightSet::statistics() const {
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

StateLightSet::StateLightSet(const IntegratorOptions& options, double cell, size_t lanes)
    : seed_(options.seed), visited_(lanes), chainMade_(cell), uniform_(cell) {}

size_t StateLightSet::steps() const {
    size_t sum = 0;
    for (const auto& lane : visited_)
        for (const Visited& v : lane) sum += v.steps;
    return sum;
}

std::vector<std::vector<Vertex>> StateLightSet::traceStates(const LightTracing& tracing) {
    std::vector<std::vector<Vertex>> result(visited_.size());
    parallelFor(visited_.size(), [&](size_t i) {
        CounterRng rng(hashKey(seed_, StreamPurpose::Replacement, i));
        std::vector<Vertex> vertices;
        for (Visited& visited : visited_[i]) {
            PrimarySampleStream u(visited.u, rng);
            InterleavedStream light(u, PathPair::kLightStream, PathPair::kStreams);
            vertices.clear();
            tracing.trace(light, vertices);
            for (const Vertex& v : vertices) chainMade_.count(v.si.p, visited.steps);
            append(result[i], vertices, visited.steps);
        }
    });
    return result;
}

std::vector<std::vector<Vertex>> StateLightSet::traceUniform(const LightTracing& tracing, size_t count,
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

std::vector<Vertex> StateLightSet::make(const LightTracing& tracing, size_t uniform, uint32_t pass,
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
