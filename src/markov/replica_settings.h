#pragma once
#include "markov/mutation.h"
#include "markov/normalization.h"

#include <array>
#include <cstdint>

namespace metrolux::core {

struct ReplicaSettings {
    uint64_t seed = 0;
    MutationKernel::Kind kernel = MutationKernel::Kind::Adaptive;
    double inefficiency = 1;  ///< ReplicaMixture::inefficiency
    int lanes = 1;
    bool uniform = true, visibility = true, contribution = true;  ///< replicas that take part
    /// n_U : n_V : n_F, positive; those of replicas that do not take part are ignored.
    std::array<double, 3> split{1, 1, 1};
    bool measuredSplit = false;  ///< SplitEstimator goes on from `split`
    NormalizationMethod normalization = NormalizationMethod::Pooled;
    bool pooledTheta = false;  ///< lanes share theta of the adaptive kernel after each iteration
    /// `split` with 0 for replicas that do not take part.
    std::array<double, 3> splitInUse() const {
        return {uniform ? split[0] : 0, visibility ? split[1] : 0, contribution ? split[2] : 0};
    }
};

/// What the lanes have done so far.
struct ReplicaCounts {
    struct Acceptance {
        uint64_t tried = 0, accepted = 0;
        double theta = 0;  ///< mean over the lanes
        double rate() const { return tried ? double(accepted) / double(tried) : 0; }
    };
    Acceptance visibility, contribution;
    uint64_t swapsTried = 0, swapsMade = 0;  ///< visibility with contribution
    uint64_t uniformSwaps = 0;               ///< uniform with visibility
};

}  // namespace metrolux::core
