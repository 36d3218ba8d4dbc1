#pragma once
#include "base/state.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace metrolux::core {

struct Estimate {
    double value = 0, standardError = 0;
};

/// How b_F is estimated.
enum class NormalizationMethod {
    Pooled,  ///< mean F of visible samples, of the uniform and the visibility replica
    Bennett  ///< from the contribution replica's samples too: bennettMean()
};

/// Counts of sizes F in bins of an eighth of an octave.
class SizeHistogram {
  public:
    void add(double size, double count = 1);
    SizeHistogram& operator+=(const SizeHistogram& other);
    void scale(double factor);
    void clear() { counts_.clear(); }
    /// Calls visit(size, count) for the bins in use, with the size in their middle.
    template <class Visit>
    void forEach(Visit&& visit) const {
        for (size_t i = 0; i < counts_.size(); ++i)
            if (counts_[i] > 0) visit(sizeOf(i), counts_[i]);
    }
    template <class Archive>
    void serialize(Archive& archive) {
        archive(counts_);
        checkState(counts_.empty() || counts_.size() == kBins, "a histogram of as many bins");
    }

  private:
    static constexpr int kBinsOfAnOctave = 8, kOctaves = 64;  ///< on either side of 1
    static constexpr size_t kBins = 2 * kOctaves * kBinsOfAnOctave;
    static double sizeOf(size_t bin);
    std::vector<double> counts_;
};

/// Mean of F under a density v, from samples of v and of a chain with a density in proportion to v F: the
/// fixed point of
///     m = sum over all samples of F / (n_v + n_F F / m),
/// the acceptance ratio method of [Bennett 1976] for two states (multistate form: Shirts & Chodera 2008, eq.
/// 11). Weights and densities depend on F only, so that histograms of F are sufficient. 0 without samples of
/// v.
double bennettMean(const SizeHistogram& ofV, const SizeHistogram& ofF);

/// Normalizations b_V and b_F of the replicas' targets (docs/explain/algorithm.md section 3), as functions of
/// the merging radius.
///
///     b_V = share of the visible among the uniform samples,   b_F = b_V * mean of F over visible samples,
///
/// the latter over the visible uniform samples and those of the visibility chains, which follow the same
/// distribution (or as NormalizationMethod says). Inverse-variance weighting of the two classic estimators of
/// b_F was tried: for heavy-tailed F the smaller mean comes with the smaller variance, and b_F was several
/// percent low.
///
/// The targets change with the radius: where light is found by merging alone, V shrinks as r^2. A mean over
/// the past would lag behind (33 % for r^2 ~ i^-1/4), one over a short window is noisy. Both quantities are
/// therefore fitted as powers of the radius, b_V ~ (r^2)^gamma, by quasi-likelihood (Wedderburn 1974) over
/// all iterations, recent ones weighted more.
class Normalization {
  public:
    /// Samples of one lane in one iteration.
    class Samples {
      public:
        void addUniform(double size) {
            ++uniform_;
            if (!(size > 0)) return;
            ++uniformVisible_;
            uniformSize_ += size;
            if (histograms_) visibleSizes_.add(size);
        }
        /// A state of the visibility chain, visible.
        void addVisibility(double size) {
            ++visibility_;
            visibilitySize_ += size;
            if (histograms_) visibleSizes_.add(size);
        }
        /// A state of the contribution chain.
        void addContribution(double size) {
            if (histograms_ && size > 0) contributionSizes_.add(size);
        }
        void clear() {
            uniform_ = uniformVisible_ = uniformSize_ = visibility_ = visibilitySize_ = 0;
            visibleSizes_.clear();
            contributionSizes_.clear();
        }

      private:
        friend class Normalization;
        double uniform_ = 0, uniformVisible_ = 0, uniformSize_ = 0, visibility_ = 0, visibilitySize_ = 0;
        bool histograms_ = false;
        SizeHistogram visibleSizes_, contributionSizes_;
    };

    explicit Normalization(NormalizationMethod method = NormalizationMethod::Pooled) : method_(method) {}
    /// Of a lane, to be filled and given to add().
    Samples newSamples() const {
        Samples s;
        s.histograms_ = method_ == NormalizationMethod::Bennett;
        return s;
    }

    /// Adds a lane's samples to the iteration. Lanes must be added in a fixed order: sums do not depend on
    /// threads then.
    void add(int lane, const Samples& samples);
    /// Closes an iteration that was made with this squared radius.
    void endIteration(double squaredRadius);
    /// Solves for b_V and b_F at the squared radius of the next iteration.
    void update(double squaredRadius);
    /// Drops the sizes F of the samples so far (the weights in F have changed); what was visible stays known.
    void forgetSizes();

    double visibility() const { return value_.visibility; }
    double contribution() const { return value_.contribution; }
    /// Number of visible samples whose sizes are known. If they are independent, b_V is known to one part in
    /// its root.
    double visibleSamples() const;

    /// Between two iterations.
    template <class Archive>
    void serialize(Archive& archive) {
        serializeAtMost(archive, records_, kMostRecords, "iterations");
        archive(iterations_, logRadius_, value_, visibleSizes_, contributionSizes_);
        checkState(value_.visibility > 0 && value_.contribution > 0, "positive normalizations");
    }

    /// With standard errors, for reports: jackknife over groups of lanes.
    Estimate visibilityEstimate() const { return jackknife(&Solution::visibility); }
    Estimate contributionEstimate() const { return jackknife(&Solution::contribution); }

  private:
    static constexpr int kGroups = 8;
    static constexpr size_t kMostRecords = 256;
    struct Counts {
        double uniform = 0, uniformVisible = 0, visible = 0, size = 0;
        Counts& operator+=(const Counts& other);
        template <class Archive>
        void serialize(Archive& archive) {
            archive(uniform, uniformVisible, visible, size);
        }
    };
    /// Consecutive iterations.
    struct Record {
        double index = 0, iterations = 0;  ///< mean number of the iteration, how many
        double logRadius = 0;              ///< mean of log r^2
        std::vector<Counts> groups = std::vector<Counts>(kGroups);
        template <class Archive>
        void serialize(Archive& archive) {
            archive(index, iterations, logRadius);
            serializeElements(archive, groups, "groups");
        }
    };
    struct Solution {
        double visibility = 1, contribution = 1;
        template <class Archive>
        void serialize(Archive& archive) {
            archive(visibility, contribution);
        }
    };
    Solution solve(int withoutGroup) const;
    /// Bennett's mean over the plain one, both of recent samples.
    double bennettFactor() const;
    Estimate jackknife(double Solution::*which) const;

    NormalizationMethod method_;
    SizeHistogram visibleSizes_, contributionSizes_;  ///< of recent iterations
    std::vector<Record> records_;
    Record current_;
    double iterations_ = 0, logRadius_ = 0;
    Solution value_;
};

/// A sum of counts y_i out of exposures n_i, of weight w_i, whose expectation is n_i exp(a + gamma x_i).
struct TrendPoint {
    double x, exposure, count, weight;
};
/// Fits a and gamma (within the bounds) by quasi-likelihood and returns exp(a + gamma x). 0 without counts or
/// exposure.
double fitTrend(const std::vector<TrendPoint>& points, double x, double gammaMin, double gammaMax);

}  // namespace metrolux::core
