#pragma once
/// Comparison of images by the means of blocks over independent seeds. The scatter between seeds is the only
/// source of error estimates, so that they hold for correlated samples (Markov chains, shared light subpaths)
/// and for filters.

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace metrolux::core::test {

/// Means and variances over seeds of each color channel of each block of an image. Blocks at the right and
/// lower edges take what is left.
class BlockStatistics {
  public:
    BlockStatistics(int width, int height, int columns, int rows)
        : width_(width), height_(height), columns_(columns), rows_(rows), sum_(size()), sumSquares_(size()) {}

    size_t size() const { return columns_ * rows_ * 3; }
    int seeds() const { return seeds_; }

    /// Block means of an image, 3 channels interleaved.
    std::vector<double> blockMeans(const std::vector<float>& image) const {
        std::vector<double> means(size()), counts(size());
        for (size_t i = 0; i < image.size(); ++i) {
            means[indexOf(i)] += image[i];
            ++counts[indexOf(i)];
        }
        for (size_t i = 0; i < means.size(); ++i) means[i] /= counts[i];
        return means;
    }

    /// Sets all pixels of a block, in one channel.
    void fill(std::vector<float>& image, size_t block, float value) const {
        for (size_t i = 0; i < image.size(); ++i)
            if (indexOf(i) == block) image[i] = value;
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
    /// Block and channel of element i of an image.
    size_t indexOf(size_t i) const {
        const size_t pixel = i / 3, x = pixel % width_, y = pixel / width_;
        return (y * rows_ / height_ * columns_ + x * columns_ / width_) * 3 + i % 3;
    }

    size_t width_, height_, columns_, rows_;
    int seeds_ = 0;
    std::vector<double> sum_, sumSquares_;
};

/// One comparison of a block: the difference, its standard error and what the test makes of them.
struct WelchResult {
    double difference = 0, standardError = 0, degreesOfFreedom = 1, pValue = 1;

    /// The smallest difference that a two-sided test at this level would have called one.
    double halfWidth(double level) const {
        const boost::math::students_t distribution(degreesOfFreedom);
        return standardError * boost::math::quantile(boost::math::complement(distribution, level / 2));
    }
};

/// Two-sided test that two means are equal, with unequal variances [Welch 1947]. Both zero: p = 1.
inline WelchResult welch(double meanA, double varianceA, double dofA, double meanB, double varianceB,
                         double dofB) {
    WelchResult r;
    r.difference = meanA - meanB;
    const double variance = varianceA + varianceB;
    r.standardError = std::sqrt(variance);
    if (variance <= 0) return r;
    r.degreesOfFreedom = variance * variance / (varianceA * varianceA / dofA + varianceB * varianceB / dofB);
    const boost::math::students_t distribution(r.degreesOfFreedom);
    r.pValue =
        2 * boost::math::cdf(boost::math::complement(distribution, std::abs(r.difference) / r.standardError));
    return r;
}

/// Level of each of n tests such that all together err with probability `familyRate` when they are
/// independent (Sidak); less when they are positively correlated, as neighboring blocks and colors are.
inline double sidak(double familyRate, double n) { return -std::expm1(std::log1p(-familyRate) / n); }

}  // namespace metrolux::core::test
