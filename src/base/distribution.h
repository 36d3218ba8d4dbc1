#pragma once
#include "base/math.h"

#include <span>
#include <vector>

namespace metrolux::core {

/// Discrete distribution over indices, sampled by inverting its cumulative sum.
class DiscreteDistribution {
  public:
    DiscreteDistribution() = default;
    /// Weights must be finite and not negative (throws Error otherwise). If all are zero the distribution is
    /// empty.
    explicit DiscreteDistribution(std::span<const double> weights);
    bool empty() const { return !(sum_ > 0); }
    size_t size() const { return cdf_.empty() ? 0 : cdf_.size() - 1; }
    double sum() const { return sum_; }
    double pmf(size_t i) const { return cdf_[i + 1] - cdf_[i]; }
    /// Index with probability pmf(index); `u` is rescaled to a fresh uniform number in [0, 1).
    size_t sample(float& u) const;

  private:
    std::vector<double> cdf_;
    double sum_ = 0;
};

/// Piecewise-constant density on the unit square, row by row (used for environment maps and textured lights).
class Distribution2D {
  public:
    Distribution2D() = default;
    /// values[y * width + x] >= 0.
    Distribution2D(std::span<const float> values, int width, int height);
    bool empty() const { return !(total_ > 0); }
    double total() const { return total_; }  ///< mean of the values
    /// Point of the unit square; pdf with respect to its area.
    Vec2f sample(const Vec2f& u, float& pdf) const;
    float pdf(const Vec2f& point) const;

  private:
    int width_ = 0, height_ = 0;
    double total_ = 0;
    std::vector<double> rowCdf_;  // height + 1
    std::vector<float> cdf_;      // height * (width + 1), each row normalized
};

}  // namespace metrolux::core
