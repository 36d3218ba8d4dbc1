#include "integrators/description.h"
#include "integrators/iteration.h"
#include "integrators/path_chains.h"
#include "integrators/resumable.h"
#include "sampling/streams.h"

#include <nlohmann/json.hpp>

#include <cmath>

namespace metrolux::core {

namespace {

/// Paths of this many edges and more share one set of chains, whose length is a coordinate too: so that a
/// scene without depth limit has finitely many sets.
constexpr int kLongPaths = 14;
/// A long path of kLongPaths + i edges is chosen with probability (1 - p) p^i.
constexpr double kContinuation = 0.75;
/// Share of the samples that is spread evenly over lengths, whatever the first samples say of them.
constexpr double kEvenShare = 0.1;

/// Multiplexed Metropolis light transport (Hachisuka, Kaplanyan, Dachsbacher 2014): for each path length,
/// chains whose state also says which technique (s, t) makes the path; each technique is weighted by multiple
/// importance sampling, so that chains prefer the technique that does well.
class MmltIntegrator final : public Resumable<MmltIntegrator> {
  private:
    /// The integrand of paths of `length` edges; the longest stands for all that are longer.
    auto evaluator(const PathPair& pair, int length) const {
        return [this, &pair, length](SampleStream& u, PathValue& value) {
            double scale = 1;
            const bool longPaths = length == kLongPaths && options_.limits.maxDepth != kLongPaths;
            const int chosen = longPaths ? chooseLong(u, scale) : length;
            if (options_.limits.maxDepth >= 0 && chosen > options_.limits.maxDepth) {
                value.splats.clear();
                value.size = 0;
                return;
            }
            pair.one(chosen, u, value.splats);
            for (SplatList::FilmSplat& splat : value.splats.film) splat.value *= static_cast<float>(scale);
            value.size = value.splats.size();
        };
    }

  public:
    MmltIntegrator(const Scene& scene, const CommonOptions& options, const MetropolisParameters& parameters)
        : scene_(scene),
          options_(options),
          pixels_(hilbertOrder(scene.camera().window().width, scene.camera().window().height)) {
        const int maxDepth = options.limits.maxDepth;
        const int longest = maxDepth < 0 ? kLongPaths : std::min(maxDepth, kLongPaths);
        for (int length = 2; length <= longest; ++length) {
            samplers_.emplace_back(
                pathSamplerOptions(options.seed, parameters, pixels_.size() / 8, uint64_t(length)));
        }
    }

    void addPass(Film& film, uint32_t pass) override {
        const Strategies strategies = Strategies::bidirectional(1, 0);
        directPass({scene_, options_.limits, strategies, nonFinite_, options_.seed, pass}, pixels_, film);
        const PathPair pair{scene_, options_.limits, strategies, film, nonFinite_};
        if (budgets_.empty()) shareOut(pair);
        for (size_t i = 0; i < samplers_.size(); ++i)
            samplers_[i].integrate(budgets_[i], evaluator(pair, int(i) + 2), payTo(film));
    }

    template <class Archive>
    void serialize(Archive& archive) {
        serializeElements(archive, samplers_, "path lengths");
        for (const PathSampler& sampler : samplers_) checkPixels(sampler, scene_.camera().window());
        archive(budgets_);
        checkState(budgets_.empty() || budgets_.size() == samplers_.size(), "a budget for each path length");
        for (const size_t budget : budgets_) checkState(budget <= pixels_.size(), "budgets below a pass");
    }
    nlohmann::json statistics() const override {
        nlohmann::json j;
        nlohmann::json& lengths = j["lengths"] = nlohmann::json::array();
        for (size_t i = 0; i < samplers_.size(); ++i) {
            lengths.push_back(samplerStatistics(samplers_[i]));
            lengths.back()["edges"] = i + 2;
            if (!budgets_.empty()) lengths.back()["samples_per_pass"] = budgets_[i];
        }
        return j;
    }
    std::string progressNote() const override {
        PathSampler::Counts sum;
        for (const PathSampler& sampler : samplers_) sum += sampler.counts();
        return acceptanceNote(sum);
    }

  private:
    /// Length of a long path; `scale`: one over its probability.
    static int chooseLong(SampleStream& u, double& scale) {
        InterleavedStream eye(u, layout::kEyeStream, layout::kStreams);
        const double uLength = read(eye, layout::kLength);
        const double extra = std::floor(std::log1p(-uLength) / std::log(kContinuation));
        scale = 1 / ((1 - kContinuation) * std::pow(kContinuation, extra));
        return kLongPaths + static_cast<int>(extra);
    }

    /// Samples of a pass among lengths, in proportion to their first normalizations, once for all passes.
    void shareOut(const PathPair& pair) {
        double sum = 0;
        for (size_t i = 0; i < samplers_.size(); ++i) {
            samplers_[i].calibrate(evaluator(pair, int(i) + 2));
            sum += samplers_[i].steering();
        }
        const double even = 1.0 / double(samplers_.size()), n = double(pixels_.size());
        for (const PathSampler& sampler : samplers_) {
            const double share =
                sum > 0 ? kEvenShare * even + (1 - kEvenShare) * sampler.steering() / sum : even;
            budgets_.push_back(std::max<size_t>(1, static_cast<size_t>(std::llround(share * n))));
        }
    }

    const Scene& scene_;
    CommonOptions options_;
    std::vector<uint32_t> pixels_;
    std::vector<PathSampler> samplers_;  ///< of lengths 2, 3, ...
    std::vector<size_t> budgets_;
};

}  // namespace

IntegratorDescription mmltIntegrator() {
    return describe<MetropolisParameters, MmltIntegrator>(
        "mmlt", "multiplexed Metropolis light transport: chains choose technique and path");
}

}  // namespace metrolux::core
