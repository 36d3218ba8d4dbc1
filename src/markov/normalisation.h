#pragma once
#include <cstdint>
#include <vector>

namespace metrolux {

struct Estimate {
    double value = 0, standardError = 0;
};

/// Normalisations b_V and b_F of the replicas' targets (ALGORITHM.md section 3), from the samples of all replicas.
///
/// A visible sample's density in each replica depends on its size F alone (1, 1/b_V, F/b_F), so that counts per
/// replica and a histogram of log F over all samples are sufficient statistics. The estimate is the fixed point of the
/// multistate Bennett acceptance ratio (Bennett 1976; Shirts & Chodera 2008),
///
///     b_F = sum_j F_j W_j,   b_V = sum_j W_j,   W_j = 1 / (N_U + N_V / b_V + N_F F_j / b_F),
///
/// sums over the visible samples j. Inverse-variance weighting of the two classic estimators was tried first: for
/// heavy-tailed F the smaller mean comes with the smaller variance, and b_F was several percent low.
class Normalisation {
  public:
    /// Samples of one lane in one iteration. Weights add up to one per step of a chain (a and 1-a of a decision).
    class Samples {
      public:
        void addUniform(double size);
        void addVisibility(double size);
        void addContribution(double size, double weight);
        void clear();

      private:
        friend class Normalisation;
        struct Entry {
            double size, weight;
        };
        double uniform_ = 0, uniformVisible_ = 0, uniformSize_ = 0, uniformSize2_ = 0;
        double visibility_ = 0, visibilitySize_ = 0, contribution_ = 0;
        std::vector<Entry> visible_;
    };

    /// Adds a lane's samples. Lanes must be added in a fixed order, so that the sums do not depend on threads.
    void add(int lane, const Samples& samples);
    /// Drops the samples so far; b_V and b_F stay until the next update().
    void forget() { groups_.assign(kGroups, {}); }
    /// Weighted number of visible uniform samples: b_V is known to one in the root of it.
    double visibleUniformSamples() const;
    /// Scales the weight of all samples so far, for targets that change slowly.
    void discount(double factor);
    /// Solves for b_V and b_F; to be called once per iteration, after the lanes were added.
    void update();

    double visibility() const { return bVisibility_; }
    double contribution() const { return bContribution_; }

    // With standard errors, for reports: jackknife over groups of lanes.
    Estimate visibilityEstimate() const { return jackknife(&Solution::visibility); }
    Estimate contributionEstimate() const { return jackknife(&Solution::contribution); }
    /// The classic ones of ALGORITHM.md, for comparison: share of visible uniform samples; mean of F over uniform samples;
    /// b_V times the mean of F over the visibility chains.
    Estimate visibilityFromUniform() const;
    Estimate contributionFromUniform() const;
    double contributionFromVisibility() const;

  private:
    static constexpr int kGroups = 8;
    static constexpr int kBins = 4096;
    struct Sums {
        double uniform = 0, uniformVisible = 0, uniformSize = 0, uniformSize2 = 0;
        double visibility = 0, visibilitySize = 0, contribution = 0;
        std::vector<double> weight, size;  // per bin: sum of weights, sum of weight * F
    };
    struct Solution {
        double visibility = 1, contribution = 1;
    };
    static int binOf(double size);
    Sums total(int withoutGroup = -1) const;
    Solution solve(const Sums& sums) const;
    Estimate jackknife(double Solution::*which) const;

    std::vector<Sums> groups_ = std::vector<Sums>(kGroups);
    double bVisibility_ = 1, bContribution_ = 1;
};

}  // namespace metrolux
