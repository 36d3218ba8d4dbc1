#pragma once
/// Comparison of images by the means of blocks over independent seeds. The scatter between seeds is the only source of
/// error estimates, so that they hold for correlated samples (Markov chains, shared light subpaths) and for filters.

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <vector>

namespace metrolux::test {

/// Means and variances over seeds of each colour channel of each block of an image. Blocks at the right and lower edges
/// take what is left.
class BlockStatistics {
  public:
    BlockStatistics(int width, int height, int columns, int rows)
        : width_(width), height_(height), columns_(columns), rows_(rows), sum_(size()), sumSquares_(size()) {}

    size_t size() const { return size_t(columns_) * rows_ * 3; }
    int seeds() const { return seeds_; }

    /// Block means of an image, 3 channels interleaved.
    std::vector<double> blockMeans(const std::vector<float>& image) const {
        std::vector<double> means(size()), counts(size());
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                for (int c = 0; c < 3; ++c) {
                    const size_t block = (size_t(y) * rows_ / height_ * columns_ + size_t(x) * columns_ / width_) * 3 + c;
                    means[block] += image[(size_t(y) * width_ + x) * 3 + c];
                    ++counts[block];
                }
        for (size_t i = 0; i < means.size(); ++i) means[i] /= counts[i];
        return means;
    }

    /// Adds the image that one seed made.
    void add(const std::vector<float>& image) {
        const std::vector<double> means = blockMeans(image);
        for (size_t i = 0; i < means.size(); ++i) {
            sum_[i] += means[i];
            sumSquares_[i] += means[i] * means[i];
        }
        ++seeds_;
    }

    double mean(size_t i) const { return sum_[i] / seeds_; }
    /// Variance of mean(i). Not below rounding: 1e-5 of the mean, which films and single precision may add.
    double varianceOfMean(size_t i) const {
        const double m = mean(i);
        const double v = std::max(0.0, (sumSquares_[i] - seeds_ * m * m) / (seeds_ - 1.0)) / seeds_;
        return std::max(v, 1e-10 * m * m);
    }
    int degreesOfFreedom() const { return seeds_ - 1; }

    /// Mean of the whole image, over blocks and channels.
    double total() const {
        double s = 0;
        for (size_t i = 0; i < size(); ++i) s += mean(i);
        return s / double(size());
    }

  private:
    int width_, height_, columns_, rows_;
    int seeds_ = 0;
    std::vector<double> sum_, sumSquares_;
};

/// One comparison of a block: the difference, its standard error and what the test makes of them.
struct WelchResult {
    double difference = 0, standardError = 0, degreesOfFreedom = 0, pValue = 1;
};

/// Two-sided test that two means are equal, with unequal variances [Welch 1947]. Both zero: p = 1.
inline WelchResult welch(double meanA, double varianceA, double dofA, double meanB, double varianceB, double dofB) {
    WelchResult r;
    r.difference = meanA - meanB;
    const double variance = varianceA + varianceB;
    r.standardError = std::sqrt(variance);
    if (variance <= 0) return r;
    r.degreesOfFreedom = variance * variance / (varianceA * varianceA / dofA + varianceB * varianceB / dofB);
    const boost::math::students_t distribution(r.degreesOfFreedom);
    r.pValue = 2 * boost::math::cdf(boost::math::complement(distribution, std::abs(r.difference) / r.standardError));
    return r;
}

/// Level of each of n tests such that all together err with probability `familyRate` when they are independent (Sidak);
/// less when they are positively correlated, as neighbouring blocks and colours are.
inline double sidak(double familyRate, double n) { return -std::expm1(std::log1p(-familyRate) / n); }

}  // namespace metrolux::test
