#pragma once
#include <cstdint>
#include <vector>

namespace metrolux {

/// Running estimate of a mean with its standard error.
class RunningMean {
  public:
    void add(double x) {
        ++n_;
        const double delta = x - mean_;
        mean_ += delta / double(n_);
        m2_ += delta * (x - mean_);
    }
    /// As if all samples of `other` had been added.
    void merge(const RunningMean& other);
    uint64_t count() const { return n_; }
    double mean() const { return mean_; }
    double variance() const { return n_ > 1 ? m2_ / double(n_ - 1) : 0; }
    /// Of independent samples; infinite while there are fewer than two.
    double standardError() const;

  private:
    uint64_t n_ = 0;
    double mean_ = 0, m2_ = 0;
};

struct Estimate {
    double value = 0, standardError = 0;
};

/// Normalisations of the replicas' targets, ALGORITHM.md section 3: b_V is the share of uniform samples that are
/// visible, b_F the mean of F over uniform samples or b_V times its mean over the visibility chains. Sums of one lane and
/// iteration are merged in a fixed order, so that the result does not depend on threads.
class Normalisation {
  public:
    struct LaneSums {
        RunningMean uniformVisible;  ///< V of uniform samples
        RunningMean uniformSize;     ///< F of uniform samples
        double visibilitySize = 0;   ///< sum of F over the samples of the visibility chain
        uint64_t visibilityCount = 0;
    };
    explicit Normalisation(int lanes) : lanes_(lanes) {}

    void add(int lane, const LaneSums& sums);
    /// Uniform samples of a plain pass.
    void addUniform(double size);

    Estimate visibility() const;  ///< b_V
    Estimate contribution() const;  ///< b_F: both estimators, weighted by their estimated precision
    Estimate contributionFromUniform() const;
    Estimate contributionFromVisibility() const;

  private:
    struct Lane {
        double size = 0;
        uint64_t count = 0;
    };
    std::vector<Lane> lanes_;
    RunningMean visible_, size_;
};

}  // namespace metrolux
