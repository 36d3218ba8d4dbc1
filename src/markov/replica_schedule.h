#pragma once
/// How the samples of an iteration are dealt out: to the replicas, to the lanes, to the steps of a lane.

#include "markov/replica_mixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace metrolux::core {

/// Steps of lane `lane` when `lanes` lanes share `steps` of them: parts that differ by one at most.
inline size_t stepsOfLane(size_t steps, size_t lanes, size_t lane) {
    return steps * (lane + 1) / lanes - steps * lane / lanes;
}

/// Samples of each replica, about `samples` together, in the proportions of `parts`: the same number in every
/// lane, at least one where the part is positive, and none where it is 0.
inline std::array<double, 3> replicaSamples(const std::array<double, 3>& parts, size_t samples,
                                            size_t lanes) {
    const double sum = parts[0] + parts[1] + parts[2], n = double(lanes);
    std::array<double, 3> result{};
    for (size_t k = 0; k < 3; ++k)
        if (parts[k] > 0)
            result[k] = std::max(1.0, std::ceil(std::floor(parts[k] * double(samples) / sum) / n)) * n;
    return result;
}

/// The steps of a lane in an iteration: as many as its most numerous replica has samples, over which the
/// samples of the others are spread evenly.
class ReplicaSchedule {
  public:
    /// `mix`: of all lanes.
    ReplicaSchedule(const ReplicaMixture& mix, size_t lanes)
        : mix_(mix), lanes_(lanes), most_(std::max({mix.uniform, mix.visibility, mix.contribution})) {}

    size_t steps() const { return perLane(most_); }
    size_t uniformSamples() const { return perLane(mix_.uniform); }

    /// Replicas that take a sample in a step.
    struct Due {
        bool uniform, visibility, contribution;
    };
    Due at(size_t step) const {
        return {due(step, mix_.uniform), due(step, mix_.visibility), due(step, mix_.contribution)};
    }

  private:
    size_t perLane(double samples) const { return static_cast<size_t>(samples) / lanes_; }
    bool due(size_t step, double samples) const {
        const auto before = [&](size_t s) { return std::floor(double(s) * samples / most_); };
        return before(step + 1) > before(step);
    }

    const ReplicaMixture& mix_;
    size_t lanes_;
    double most_;
};

}  // namespace metrolux::core
