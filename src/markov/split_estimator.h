#pragma once
/// The split n_U : n_V : n_F of an iteration's samples that makes the least noise.

#include "base/math.h"
#include "base/state.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace metrolux::core {

/// With the balance heuristic over n'_k effective samples of densities p_k, the noise of a pass is about
/// M = integral of f^2 / (sum of n'_k p_k), a convex function of the n'_k whose derivatives are
/// -E_k[(w f)^2], w being the heuristic's weight and E_k the mean over replica k [He & Owen 2014]. At the
/// best split of a fixed number of samples the derivatives are equal. So the mean squares of what each
/// replica contributes say where samples are missing: n_k is multiplied by their square root (the
/// multiplicative algorithm of optimal design). Samples of each replica are taken to cost the same.
class SplitEstimator {
  public:
    enum Replica : size_t { Uniform, Visibility, Contribution };

    /// Squared contributions of an iteration, of one lane.
    struct Squares {
        std::array<double, 3> sums{}, samples{};
        void add(Replica replica, double square) {
            sums[replica] += square;
            samples[replica] += 1;
        }
    };

    explicit SplitEstimator(const std::array<double, 3>& start) : split_(start) {}

    const std::array<double, 3>& split() const { return split_; }

    void add(const Squares& squares) {
        for (size_t k = 0; k < 3; ++k) {
            batch_.sums[k] += squares.sums[k];
            batch_.samples[k] += squares.samples[k];
        }
    }
    /// `inefficiency`: that of the chains, whose n'_k are n_k over it. Batches double, so that the split
    /// comes to rest.
    void endIteration(double inefficiency) {
        if (++iterations_ < batchLength_) return;
        update(inefficiency);
        batch_ = {};
        iterations_ = 0;
        batchLength_ *= 2;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        const std::array<double, 3> before = split_;
        serializeElements(archive, split_, "replicas");
        for (size_t k = 0; k < 3; ++k)
            checkState(std::isfinite(split_[k]) && split_[k] >= 0 && (split_[k] > 0) == (before[k] > 0),
                       "a split among the same replicas");
        serializeElements(archive, batch_.sums, "replicas");
        serializeElements(archive, batch_.samples, "replicas");
        archive(iterations_, batchLength_);
    }

  private:
    /// No replica in use gets less, however little it contributes: its share also finds what the others miss.
    static constexpr double kSmallestShare = 0.1;

    void update(double inefficiency) {
        std::array<double, 3> next{};
        double total = 0;
        for (size_t k = 0; k < 3; ++k) {
            if (!(split_[k] > 0)) continue;
            if (!(batch_.samples[k] > 0)) return;
            const double slope = batch_.sums[k] / batch_.samples[k] / (k == Uniform ? 1 : inefficiency);
            next[k] = split_[k] * std::sqrt(slope);
            total += next[k];
        }
        if (!(total > 0) || !std::isfinite(total)) return;
        double sum = 0;
        for (size_t k = 0; k < 3; ++k) {
            if (split_[k] > 0) next[k] = std::max(next[k] / total, kSmallestShare);
            sum += next[k];
        }
        for (size_t k = 0; k < 3; ++k) split_[k] = next[k] / sum;
    }

    std::array<double, 3> split_;
    Squares batch_;
    uint64_t iterations_ = 0, batchLength_ = 4;
};

}  // namespace metrolux::core
