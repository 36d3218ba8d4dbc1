#pragma once
#include "base/state.h"

#include <array>
#include <cstddef>
#include <vector>

namespace metrolux::core {

/// How many times as dense as independent ones the samples of a ReplicaMixture are, where it matters. The
/// density of a sample u is 1 / W(u) of independent samples' (ReplicaMixture), from n_U where only the
/// uniform replica comes to orders of magnitude more where the contribution replica stays. Its means over
/// what samples contribute come from the samples themselves: sum of weight x value is the integral of value
/// over u.
///
/// Integrals are taken over many iterations, of which old ones fade, in a fixed order of the lanes.
class MixtureDensity {
  public:
    explicit MixtureDensity(size_t lanes) : current_(lanes) {}

    /// A sample of a lane has been paid with `weight`; W is its weight as a uniform sample. `shared` is that
    /// of its value, of any scale.
    void add(size_t lane, double weight, double W, double shared) {
        current_[lane][0] += weight * shared;
        current_[lane][1] += weight * W * shared;
    }
    void endIteration() {
        constexpr double kMemory = 0.9;
        for (double& s : sums_) s *= kMemory;
        for (Sums& lane : current_)
            for (size_t i = 0; i < lane.size(); ++i) sums_[i] += lane[i], lane[i] = 0;
    }

    /// Harmonic mean of the number of independent samples that the mixture is as dense as, over what is
    /// shared with eye subpaths. 0 before it is known.
    double ofShared() const { return sums_[1] > 0 ? sums_[0] / sums_[1] : 0; }

    /// Between two iterations.
    template <class Archive>
    void serialize(Archive& archive) {
        serializeElements(archive, sums_, "sums");
    }

  private:
    using Sums = std::array<double, 2>;
    std::vector<Sums> current_;
    Sums sums_{};
};

}  // namespace metrolux::core
